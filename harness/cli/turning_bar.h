/// A bar that turns, for what the gallery shows of curved motion.
#pragma once

#include <cstddef>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// About `triangles` of a bumpy bar along x, which turns round z as many `turns` while the shutter is open,
/// in `steps` steps.
Scene make_turning_bar(double turns, std::size_t steps, std::size_t triangles);

}  // namespace stbvh::harness
