/// Materials of Embree XML files.
#pragma once

#include <map>
#include <pugixml.hpp>
#include <string>

#include "harness/scenes/embree_xml/problem.h"
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

 private:
  const Warn& warn_;
  std::map<std::string, Material> by_id_;
};

}  // namespace stbvh::harness::embree_xml
