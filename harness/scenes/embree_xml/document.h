/// An Embree XML file, and the binary file beside it that arrays may stand in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "harness/files/input_file.h"
#include "harness/scenes/affine.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::embree_xml {

class Document {
 public:
  /// Reads and parses `file`; keeps its text, to name lines. Throws Problem.
  explicit Document(const std::filesystem::path& file);

  /// The element <scene>.
  pugi::xml_node scene() const { return scene_; }
  /// ", line 3" for a byte of the file; nothing where that is negative, or the text is not UTF-8.
  std::string place(std::ptrdiff_t offset) const;

  /// The numbers in `array`: its text, or `size` elements of `per_element` 4-byte numbers each from byte
  /// `ofs` of the binary file. Nothing where `array` is not there. Throws Problem, also for half an element.
  std::vector<float> floats(pugi::xml_node array, std::size_t per_element);
  std::vector<std::uint32_t> integers(pugi::xml_node array, std::size_t per_element);
  /// Three floats for each vertex, maybe not finite.
  VertexBuffer positions(pugi::xml_node array);
  /// Twelve floats for each map: the three columns of its matrix, then its translation. Only in binary.
  std::vector<Affine> affine_columns(pugi::xml_node array);

 private:
  template <class T>
  std::vector<T> numbers(pugi::xml_node array, std::size_t per_element);
  void read_binary(pugi::xml_node array, std::size_t element_bytes, std::vector<char>& bytes);
  void open_binary(pugi::xml_node array);

  std::filesystem::path file_;
  std::string text_;
  bool is_utf8_ = true;
  pugi::xml_document xml_;
  pugi::xml_node scene_;
  std::filesystem::path binary_path_;
  std::optional<InputFile> binary_;
  std::size_t bytes_read_ = 0;  ///< of arrays, together
};

/// An attribute of `count` floats, all finite. Throws Problem where it is missing or anything else.
std::vector<float> float_attribute(pugi::xml_node node, const char* name, std::size_t count);

/// All text of an element, without the comments in it.
std::string text_of(pugi::xml_node node);

}  // namespace stbvh::harness::embree_xml
