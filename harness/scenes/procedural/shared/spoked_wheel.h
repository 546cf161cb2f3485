/// Spoked wheels, for everything that rolls.
#pragma once

#include "harness/scenes/procedural/shared/machine_parts.h"

namespace stbvh::harness {

/// A wheel about the z axis through the origin.
struct SpokedWheel {
  double radius = 1;
  double rim = 0.1;  ///< depth of the rim, inwards
  double width = 0.12;
  std::size_t spokes = 12;
  double spoke_radius = 0.03;
  double hub_radius = 0.15;
  double hub_width = 0.2;
  double flange = 0;  ///< how far the flange on the far side (towards -z) stands out; 0: none
};

/// Its pieces, to be painted in different colours.
struct WheelPatches {
  Patches rim;
  Patches spokes;
  Patches hub;
};

WheelPatches make_spoked_wheel(const SpokedWheel& wheel);

/// Ring with a rectangular section about the z axis.
Patches flat_ring(double inner, double outer, double width, std::size_t around = 12);

/// Turning about the axle along z through `center` by `radians` over the shutter; positive is anticlockwise
/// as seen from +z.
Motion spin(Vec3 center, double radians);

}  // namespace stbvh::harness
