/// Reading glTF accessors: strides, sparse values and normalised integers honoured, every bound checked
/// first.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <string_view>
#include <vector>

namespace stbvh::harness::gltf {

/// All components of all elements as numbers; normalised integers become fractions of 1.
/// `type` is the TINYGLTF_TYPE_ that the accessor must have, `use` names it in messages. Throws Problem.
std::vector<double> read_numbers(const tinygltf::Model& model, int accessor, int type, std::string_view use);

/// Likewise for unsigned integers of 1, 2 or 4 bytes, as they are stored.
std::vector<std::uint32_t> read_integers(const tinygltf::Model& model, int accessor, int type,
                                         std::string_view use);

}  // namespace stbvh::harness::gltf
