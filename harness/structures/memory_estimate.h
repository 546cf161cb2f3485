/// How much memory a structure will take, before it is built.
#pragma once

#include <cstddef>
#include <string_view>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Bytes that building the structure `name` over `scene` is expected to take at its largest, without the
/// scene's own buffers. A rough figure, to refuse what cannot fit; measured ones are in the build records.
std::size_t estimate_peak_bytes(std::string_view name, const Scene& scene);

/// Memory that the machine can give now (MemAvailable of /proc/meminfo).
std::size_t available_memory_bytes();

}  // namespace stbvh::harness
