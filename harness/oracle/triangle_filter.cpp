#include "harness/oracle/triangle_filter.h"

#include <algorithm>
#include <cmath>

namespace stbvh::harness {
namespace {

/// Not less than the length.
double size(Vec2 a) {
  return std::abs(a.x) + std::abs(a.y);
}

/// Sign of the edge function, 0 if unknown.
int certain_side(Vec2 a, Vec2 b, double error) {
  const double w = a.x * b.y - a.y * b.x;
  const double bound = error * (size(a) + size(b) + error);
  return w > bound ? 1 : w < -bound ? -1 : 0;
}

}  // namespace

Covering certain_covering(const std::array<Vec2, 3>& corners, Vec2 nearest, double error) {
  const double bound = error * size(nearest);
  const bool is_apart = std::all_of(corners.begin(), corners.end(),
                                    [&](Vec2 s) { return s.x * nearest.x + s.y * nearest.y > bound; });
  if (is_apart) return Covering::kOutside;
  const int side = certain_side(corners[1], corners[2], error);
  const bool is_around = side != 0 && side == certain_side(corners[2], corners[0], error) &&
                         side == certain_side(corners[0], corners[1], error);
  return is_around ? Covering::kInside : Covering::kUnknown;
}

Plane::Plane(const std::array<Vec3, 3>& q, Vec3 direction)
    : normal(cross(q[1] - q[0], q[2] - q[0])),
      edges(length(q[1] - q[0]) + length(q[2] - q[0])),
      facing(dot(normal, direction)) {}

std::optional<Interval> certain_depth(const std::array<Vec3, 3>& q, Vec3 direction, const Plane& plane,
                                      double error) {
  const double turn = plane.turn(error);
  if (!(std::abs(plane.facing) > 2 * turn)) return std::nullopt;
  const double depth = dot(plane.normal, q[0]) / plane.facing;
  if (std::abs(depth) > 2 * std::max({length(q[0]), length(q[1]), length(q[2])})) return std::nullopt;
  const double reach = length(q[0] - direction * depth);
  const double bound =
      (error * (length(plane.normal) + turn) + turn * (reach + error)) / (std::abs(plane.facing) - turn);
  return Interval{depth - bound, depth + bound};
}

}  // namespace stbvh::harness
