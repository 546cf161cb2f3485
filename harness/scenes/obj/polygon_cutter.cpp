#include "harness/scenes/obj/polygon_cutter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "harness/scenes/obj/ear_clipper.h"
#include "harness/scenes/obj/edge_crossings.h"
#include "harness/scenes/obj/plane_points.h"

namespace stbvh::harness {
namespace {

constexpr double kLeastBend = 0.01;  ///< of a polygon's size

/// Along the normal, as long as twice the area seen along it (Newell); of polygons whose parts cancel each
/// other, such as a symmetrical figure of eight, along that of the largest part.
Vec3 area_vector(std::span<const Vec3> corners) {
  Vec3 sum{}, largest{};
  double all = 0;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3 part = cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
    sum = sum + part;
    all += length(part);
    if (length(part) > length(largest)) largest = part;
  }
  constexpr double kRounding = 1e-6;
  return length(sum) > kRounding * all ? sum : largest;
}

/// Along the axis that is nearest to `normal`, so that coordinates stay as they are; counterclockwise.
Polygon projected(std::span<const Vec3> corners, Vec3 normal) {
  const std::array<double, 3> n{normal.x, normal.y, normal.z};
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(n[i]) > std::abs(n[axis])) axis = i;
  }
  Polygon polygon;
  polygon.reserve(corners.size());
  for (const Vec3& corner : corners) {
    const std::array<double, 3> p{corner.x, corner.y, corner.z};
    const Vec2 q{p[(axis + 1) % 3], p[(axis + 2) % 3]};
    polygon.push_back(n[axis] < 0 ? Vec2{q.y, q.x} : q);
  }
  return polygon;
}

bool is_finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

bool is_bent(std::span<const Vec3> corners, Vec3 normal) {
  const Vec3 unit = normalize(normal);
  double lowest = 0, highest = 0, size = 0;
  for (const Vec3& corner : corners) {
    const Vec3 from_first = corner - corners[0];
    lowest = std::min(lowest, dot(from_first, unit));
    highest = std::max(highest, dot(from_first, unit));
    size = std::max(size, length(from_first));
  }
  return highest - lowest > kLeastBend * size;
}

/// Whether the first corner sees all of the polygon.
bool is_fan(const Polygon& p) {
  bool is_past_half_turn = false;
  for (std::size_t i = 2; i < p.size(); ++i) {
    if (!(doubled_area(p[0], p[i - 1], p[i]) > 0)) return false;
    const bool is_left = doubled_area(p[0], p[1], p[i]) >= 0;
    if (is_past_half_turn && is_left) return false;  // more than a whole turn
    is_past_half_turn = !is_left;
  }
  return true;
}

void add_fan(std::size_t corners, std::vector<std::uint32_t>& triangles) {
  for (std::uint32_t i = 2; i < corners; ++i) triangles.insert(triangles.end(), {0, i - 1, i});
}

}  // namespace

PolygonFlaws cut_polygon(std::span<const Vec3> corners, std::vector<std::uint32_t>& triangles) {
  PolygonFlaws flaws;
  const bool is_plain = corners.size() == 3 || !std::all_of(corners.begin(), corners.end(), is_finite);
  const Vec3 normal = is_plain ? Vec3{} : area_vector(corners);
  if (!(length(normal) > 0)) {
    add_fan(corners.size(), triangles);
    return flaws;
  }
  flaws.is_bent = is_bent(corners, normal);
  const Polygon polygon = projected(corners, normal);
  if (is_fan(polygon)) {
    add_fan(corners.size(), triangles);
    return flaws;
  }
  flaws.crosses_itself = crosses_itself(polygon);
  EarClipper(polygon).cut(triangles);
  return flaws;
}

}  // namespace stbvh::harness
