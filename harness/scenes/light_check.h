/// Which lights can be shown: one rule for all readers of scene files, behind their transforms and sums, and
/// for what is written.
#pragma once

#include <string>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// What is wrong with a light, to follow its name in a sentence: "has no direction". Empty where it can be
/// shown.
std::string flaw_of(const DirectionalLight& light);
/// The same for what it shines with, which is all that some lights have.
std::string flaw_of(Vec3f color);

/// Whether a light may come out of a disc of that size: from a point up to half of all directions.
inline bool is_half_angle(float degrees) {
  return degrees > 0 && degrees <= 90;
}

}  // namespace stbvh::harness
