/// From a path to a model with all buffers in memory. Images are never opened.
#pragma once

#include <filesystem>

#include "harness/scenes/gltf/model.h"

namespace stbvh::harness::gltf {

/// Reads a .glb, or a .gltf and the buffers it refers to, those that an accessor needs. Each of them has
/// exactly the bytes its byteLength says. Indices between the model's parts are not checked yet. Throws
/// Problem.
Model read_gltf_file(const std::filesystem::path& file);

}  // namespace stbvh::harness::gltf
