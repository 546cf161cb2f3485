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

/// About corner `centre`.
void add_fan(std::size_t centre, std::size_t corners, std::vector<std::uint32_t>& triangles) {
  const auto corner = [&](std::size_t i) { return static_cast<std::uint32_t>((centre + i) % corners); };
  for (std::size_t i = 2; i < corners; ++i)
    triangles.insert(triangles.end(), {corner(0), corner(i - 1), corner(i)});
}

/// Whether a triangle is wound the other way round. The areas of all, with their signs, are that of the
/// polygon, whatever is clipped: what they cover more than once is as large as those that are inverted. One
/// that is less high than the rounding of floats has no area; the rounding of doubles is far below that.
bool is_any_inverted(const Polygon& p, std::span<const std::uint32_t> triangles) {
  const double rounding = rounding_of(p);
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const Vec2 a = p[triangles[i]], b = p[triangles[i + 1]], c = p[triangles[i + 2]];
    const double longest = std::max({std::hypot(b.x - a.x, b.y - a.y), std::hypot(c.x - b.x, c.y - b.y),
                                     std::hypot(a.x - c.x, a.y - c.y)});
    if (doubled_area(a, b, c) < -rounding * longest) return true;
  }
  return false;
}

}  // namespace

PolygonFlaws cut_polygon(std::span<const Vec3> corners, std::vector<std::uint32_t>& triangles) {
  PolygonFlaws flaws;
  const auto unknown = std::find_if_not(corners.begin(), corners.end(), is_finite);
  if (unknown != corners.end()) {
    add_fan(static_cast<std::size_t>(unknown - corners.begin()), corners.size(), triangles);
    return flaws;
  }
  const Vec3 normal = corners.size() == 3 ? Vec3{} : area_vector(corners);
  if (!(length(normal) > 0)) {
    add_fan(0, corners.size(), triangles);
    return flaws;
  }
  flaws.is_bent = is_bent(corners, normal);
  const Polygon polygon = projected(corners, normal);
  if (is_fan(polygon)) {
    add_fan(0, corners.size(), triangles);
    return flaws;
  }
  const std::size_t before = triangles.size();
  EarClipper(polygon).cut(triangles);
  flaws.crosses_itself =
      crosses_itself(polygon) || is_any_inverted(polygon, std::span(triangles).subspan(before));
  return flaws;
}

}  // namespace stbvh::harness
