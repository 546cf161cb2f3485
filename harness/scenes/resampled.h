/// The same motion with another number of steps.
#pragma once

#include <cstddef>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Where the new steps are.
enum class StepPlaces {
  kEquidistant,
  kUneven,  ///< at times of their own, the same in all meshes that move over the same time
};

/// Every mesh of `scene` with `steps` steps, 2 to kMaxSteps, from its first one to its last; what stands
/// still too. Fewer, if uneven, where there are not as many floats in between. Between them the motion is
/// what it was only where the old steps are among the new ones.
Scene resampled(Scene scene, std::size_t steps, StepPlaces places = StepPlaces::kEquidistant);

}  // namespace stbvh::harness
