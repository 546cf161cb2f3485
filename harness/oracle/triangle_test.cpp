#include "harness/oracle/triangle_test.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stbvh::harness {
namespace {

struct Point2 {
  double x, y;
};

Point2 operator-(Point2 a, Point2 b) {
  return {a.x - b.x, a.y - b.y};
}
double cross2(Point2 a, Point2 b) {
  return a.x * b.y - a.y * b.x;
}
double length2(Point2 a) {
  return std::sqrt(a.x * a.x + a.y * a.y);
}

/// Distance of the origin from the line segment a b.
double distance_to_edge(Point2 a, Point2 b) {
  const Point2 e = b - a;
  const double squared = e.x * e.x + e.y * e.y;
  const double along = squared > 0 ? std::clamp(-(a.x * e.x + a.y * e.y) / squared, 0.0, 1.0) : 0.0;
  return length2({a.x + along * e.x, a.y + along * e.y});
}

/// How far a corner can move, as seen from the ray.
double movement(const OracleRay& ray, const Mesh& mesh, std::size_t prim, const TriangleMotion& motion,
                const std::array<Vec3, 3>& q) {
  double magnitude = 0;
  double fastest = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint32_t v = mesh.indices[3 * prim + c];
    magnitude = std::max(magnitude, length(to_double(mesh.steps[motion.first_segment][v])));
    if (mesh.is_static()) continue;
    for (std::size_t k = motion.first_segment; k <= motion.last_segment; ++k) {
      const Vec3 begin = to_double(mesh.steps[k][v]);
      const Vec3 end = to_double(mesh.steps[k + 1][v]);
      magnitude = std::max(magnitude, length(end));
      fastest = std::max(fastest, length(end - begin));
    }
  }
  const double reach = std::max({length(q[0]), length(q[1]), length(q[2])});
  return kRoundingUlps * kUlp * (magnitude + ray.origin_length + reach) + motion.time_movement * fastest;
}

/// Fills t and what it can become when the corners `q` move by `test.rounding`.
void find_t(const OracleRay& ray, const std::array<Vec3, 3>& q, TriangleTest& test) {
  const std::array<double, 3> depth{dot(q[0], ray.direction), dot(q[1], ray.direction),
                                    dot(q[2], ray.direction)};
  const auto [nearest, farthest] = std::minmax_element(depth.begin(), depth.end());
  const double r = test.rounding;
  double lower = *nearest - r;
  double upper = *farthest + r;
  if (test.is_inside) {
    const Vec3 e1 = q[1] - q[0];
    const Vec3 e2 = q[2] - q[0];
    const Vec3 n = cross(e1, e2);
    const double facing = dot(n, ray.direction);
    const double t = facing != 0 ? dot(n, q[0]) / facing : *nearest;
    test.t = std::clamp(t, *nearest, *farthest) / ray.direction_length;
    // Edges move by at most 2 r, and with them the normal; the plane moves by r along it.
    const double turn = 2 * r * (length(e1) + length(e2)) + 4 * r * r;
    if (std::abs(facing) > turn) {
      const double shift = r * (length(n) + turn) / (std::abs(facing) - turn);
      lower = std::max(lower, test.t * ray.direction_length - shift);
      upper = std::min(upper, test.t * ray.direction_length + shift);
    }
  }
  const double scale = kRoundingUlps * kUlp;  // the length of the direction moves too
  test.t_lower = (lower - scale * std::abs(lower)) / ray.direction_length;
  test.t_upper = (upper + scale * std::abs(upper)) / ray.direction_length;
}

}  // namespace

OracleRay::OracleRay(const Ray& ray)
    : origin(to_double(ray.origin)),
      direction(normalize(to_double(ray.direction))),
      across_x(perpendicular(direction)),
      across_y(cross(direction, across_x)),
      direction_length(length(to_double(ray.direction))),
      origin_length(length(origin)),
      tnear(ray.tnear),
      tfar(ray.tfar),
      time(ray.time) {}

TriangleMotion triangle_motion(const Mesh& mesh, float time) {
  TriangleMotion motion;
  motion.sample = motion_sample(mesh, time);
  motion.first_segment = motion.last_segment = motion.sample.segment;
  if (mesh.is_static()) return motion;
  const auto segments = static_cast<double>(mesh.segment_count());
  const double begin = mesh.time_range.begin;
  const double segment_length = (mesh.time_range.end - begin) / segments;
  // The end of the segment is computed too where a structure knows each segment by its own time range.
  const double magnitude = std::max(std::abs(begin), time + segment_length);
  motion.time_movement = kRoundingUlps * kUlp * magnitude / segment_length;
  const double f = motion.sample.fraction;
  if (f < motion.time_movement && motion.first_segment > 0) --motion.first_segment;
  if (f > 1 - motion.time_movement && motion.last_segment + 1 < mesh.segment_count()) ++motion.last_segment;
  return motion;
}

TriangleTest test_triangle(const OracleRay& ray, const Mesh& mesh, std::size_t prim,
                           const TriangleMotion& motion) {
  std::array<Vec3, 3> q = triangle_at(mesh, prim, motion.sample);
  std::array<Point2, 3> s{};
  for (std::size_t c = 0; c < 3; ++c) {
    q[c] = q[c] - ray.origin;
    s[c] = {dot(q[c], ray.across_x), dot(q[c], ray.across_y)};
  }
  TriangleTest test;
  test.rounding = movement(ray, mesh, prim, motion, q);
  const double u = cross2(s[1], s[2]);
  const double v = cross2(s[2], s[0]);
  const double w = cross2(s[0], s[1]);
  const bool is_around = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
  const bool covers = is_around && u + v + w != 0;
  const double distance =
      std::min({distance_to_edge(s[0], s[1]), distance_to_edge(s[1], s[2]), distance_to_edge(s[2], s[0])});
  test.edge_distance = covers ? distance : -distance;
  if (!covers && distance > test.rounding) return test;
  test.is_inside = covers;
  find_t(ray, q, test);
  test.is_inside = covers && test.t > ray.tnear && test.t <= ray.tfar;
  test.is_certain =
      covers && distance > test.rounding && test.t_lower > ray.tnear && test.t_upper <= ray.tfar;
  test.is_possible = test.t_upper > ray.tnear && test.t_lower <= ray.tfar;
  return test;
}

}  // namespace stbvh::harness
