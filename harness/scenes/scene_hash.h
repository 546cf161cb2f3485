/// Telling scenes apart by what they hold.
#pragma once

#include <string>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Of all that a picture of `scene` depends on, names but for: meshes, materials, lights, cameras; 32
/// hexadecimal digits. Reads all buffers, on all threads.
std::string scene_hash(const Scene& scene);

}  // namespace stbvh::harness
