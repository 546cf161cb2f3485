/// Materials of Embree XML files.
#pragma once

#include <filesystem>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <string>

#include "harness/scenes/embree_xml/problem.h"
#include "harness/scenes/name_list.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::embree_xml {

/// Reads <material> elements and remembers those with an id, for later ones that only name it.
class MaterialReader {
 public:
  explicit MaterialReader(const Warn& warn) : warn_(warn) {}

  /// The nearest of our materials; the default where there is no element. What Embree's material has besides
  /// (textures, transparency) is named in warnings, and so are unknown kinds, which become the default.
  /// Throws Problem for numbers that are none.
  Material read(pugi::xml_node material);
  /// `read`, known by `id` from now on.
  void define(const std::string& id, pugi::xml_node material);
  /// Warns of the ids that were read, but stand for no material.
  void tell_undefined(const std::filesystem::path& file) const;

 private:
  const Warn& warn_;
  std::map<std::string, Material> by_id_;
  std::set<std::string> undefined_ids_;
  NameList undefined_;  ///< these
};

}  // namespace stbvh::harness::embree_xml
