/// Reading glTF accessors: strides, sparse values and normalised integers honoured, every bound checked
/// first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "harness/scenes/gltf/model.h"

namespace stbvh::harness::gltf {

/// All components of all elements as numbers; normalised integers become fractions of 1.
/// `type` is the one that the accessor must have, `use` names it in messages. Throws Problem.
std::vector<double> read_numbers(const Model& model, std::size_t accessor, ElementType type,
                                 std::string_view use);

/// Likewise for unsigned integers of 1, 2 or 4 bytes, as they are stored.
std::vector<std::uint32_t> read_integers(const Model& model, std::size_t accessor, ElementType type,
                                         std::string_view use);

/// How many elements it has, all of which lie in their data, as do its sparse values. Throws Problem.
std::size_t checked_count(const Model& model, std::size_t accessor, std::string_view use);

/// The accessor of that number, which must be there.
const Model::Accessor& accessor_at(const Model& model, std::size_t index, std::string_view use);

}  // namespace stbvh::harness::gltf
