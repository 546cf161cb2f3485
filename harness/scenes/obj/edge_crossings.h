/// Whether a polygon is simple.
#pragma once

#include "harness/scenes/obj/plane_points.h"

namespace stbvh::harness {

/// Whether two of its edges cross inside both, by more than the rounding of floats; edges that only touch do
/// not. For n corners in n log n steps (Shamos and Hoey 1976).
bool crosses_itself(const Polygon& polygon);

}  // namespace stbvh::harness
