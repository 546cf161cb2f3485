/// The same motion with another number of steps.
#pragma once

#include <cstddef>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Every mesh of `scene` with `steps` steps, 2 to kMaxSceneSteps, over its own time range; what stands still
/// too. Between them the motion is what it was only where the new steps are among the old ones' multiples.
Scene resampled(Scene scene, std::size_t steps);

}  // namespace stbvh::harness
