/// From a path to tinygltf's model with all buffers in memory. Images are never opened.
#pragma once

#include <tiny_gltf.h>

#include <filesystem>

namespace stbvh::harness::gltf {

/// Reads a .glb, or a .gltf and the buffers it refers to. The model has no images, textures, cameras or
/// extras; each of its buffers has exactly the bytes its byteLength says. Indices between its parts are not
/// checked yet. Throws Problem, also for files that require an extension which would change the geometry.
tinygltf::Model read_gltf_file(const std::filesystem::path& file);

}  // namespace stbvh::harness::gltf
