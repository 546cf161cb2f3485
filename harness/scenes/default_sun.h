/// Where the sun stands over a scene that brings no light.
#pragma once

#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// Towards the sun, of any length: high behind the camera, to its left, so that what it looks at is lit and
/// casts shadows.
inline Vec3 to_default_sun(const Camera& camera) {
  const Vec3 up = normalize(to_double(camera.up));
  const Vec3 right = normalize(cross(to_double(camera.target) - to_double(camera.position), up));
  return up - 0.62 * right + 0.45 * cross(right, up);
}

}  // namespace stbvh::harness
