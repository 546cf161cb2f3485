#include "harness/oracle/ray_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "harness/oracle/exact_triangle.h"

namespace stbvh::harness {
namespace {

double length2(Vec2 a) {
  return std::sqrt(a.x * a.x + a.y * a.y);
}

/// The point of the line segment a b that is nearest to the origin.
Vec2 nearest_on_edge(Vec2 a, Vec2 b) {
  const Vec2 e{b.x - a.x, b.y - a.y};
  const double squared = e.x * e.x + e.y * e.y;
  const double along = squared > 0 ? std::clamp(-(a.x * e.x + a.y * e.y) / squared, 0.0, 1.0) : 0.0;
  return {a.x + along * e.x, a.y + along * e.y};
}

/// The point of the triangle's edges that is nearest to the origin.
Vec2 nearest_on_edges(const std::array<Vec2, 3>& s) {
  return std::min({nearest_on_edge(s[0], s[1]), nearest_on_edge(s[1], s[2]), nearest_on_edge(s[2], s[0])},
                  [](Vec2 a, Vec2 b) { return a.x * a.x + a.y * a.y < b.x * b.x + b.y * b.y; });
}

/// Component by component.
Vec3 absolute(Vec3 a) {
  return {std::abs(a.x), std::abs(a.y), std::abs(a.z)};
}
Vec3 largest(Vec3 a, Vec3 b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

constexpr double kRounding = kRoundingUlps * kUlp;

/// What can move the corners of one triangle.
struct Magnitudes {
  Vec3 position;  ///< the largest coordinates of a corner, in all segments that the time may fall into
  Vec3 motion;    ///< how far a corner moves at most, in each coordinate, when the time moves
};

/// In segments, as far as the segment reaches: steps with times of their own may be an ulp apart.
double movement_in_segment(const Mesh& mesh, std::size_t segment, double ray_time_movement) {
  return std::min(1.0, ray_time_movement / (mesh.step_time(segment + 1) - mesh.step_time(segment)));
}

Magnitudes magnitudes(const Mesh& mesh, std::size_t prim, const TriangleMotion& motion) {
  Magnitudes sizes;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint32_t v = mesh.indices[3 * prim + c];
    sizes.position = largest(sizes.position, absolute(to_double(mesh.steps[motion.first_segment][v])));
    if (mesh.is_static()) continue;
    Vec3 sum;
    for (std::size_t k = motion.first_segment; k <= motion.last_segment; ++k) {
      const Vec3 begin = to_double(mesh.steps[k][v]);
      const Vec3 end = to_double(mesh.steps[k + 1][v]);
      sizes.position = largest(sizes.position, absolute(end));
      if (mesh.has_step_times()) {
        sum = sum + movement_in_segment(mesh, k, motion.ray_time_movement) * absolute(end - begin);
      } else {
        sizes.motion = largest(sizes.motion, motion.time_movement * absolute(end - begin));
      }
    }
    sizes.motion = largest(sizes.motion, sum);
  }
  return sizes;
}

int largest_axis(Vec3 a) {
  const Vec3 size = absolute(a);
  if (size.z >= size.x && size.z >= size.y) return 2;
  return size.y >= size.x ? 1 : 0;
}

/// Sets the segments that `time` may fall into, moved, of a mesh whose steps have times of their own.
void reach_over_times(const Mesh& mesh, float time, TriangleMotion& motion) {
  const double first = time - motion.ray_time_movement, last = time + motion.ray_time_movement;
  while (motion.first_segment > 0 && mesh.step_times[motion.first_segment] > first) --motion.first_segment;
  while (motion.last_segment + 1 < mesh.segment_count() && mesh.step_times[motion.last_segment + 1] < last)
    ++motion.last_segment;
  for (std::size_t k = motion.first_segment; k <= motion.last_segment; ++k)
    motion.time_movement += movement_in_segment(mesh, k, motion.ray_time_movement);
}

/// One triangle as seen along a ray; asks exact arithmetic where double precision cannot tell.
class SeenTriangle {
 public:
  SeenTriangle(const OracleRay& ray, const Mesh& mesh, std::size_t prim, const TriangleMotion& motion)
      : ray_(ray), mesh_(mesh), prim_(prim), q_(triangle_at(mesh, prim, motion.sample)) {
    double reach = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      q_[c] = q_[c] - ray.origin;
      across_[c] = {dot(q_[c], ray.across_x), dot(q_[c], ray.across_y)};
      z_[c] = ray.depth_on_axis(q_[c]);
      reach = std::max(reach, length(q_[c]));
    }
    nearest_ = nearest_on_edges(across_);
    const Magnitudes sizes = magnitudes(mesh, prim, motion);
    movement_ = kRounding * (sizes.position + absolute(ray.origin)) + sizes.motion;
    const double farthest = std::max({std::abs(z_[0]), std::abs(z_[1]), std::abs(z_[2])});
    movement_across_ = movement_ + kRounding * farthest * absolute(ray.direction);
    double_error_ = kDoubleError *
                    (kRounding * (length(sizes.position) + ray.origin_length + reach) + length(sizes.motion));
  }

  bool needed_exact() const { return exact_.has_value(); }

  /// Sets `edge_distance` and `rounding`, for the edge that is nearest, in the units that corners move by.
  void find_edge(bool is_covered, TriangleTest& test) const {
    if (!is_covered) {
      test.edge_distance = -length2(nearest_);
      test.rounding = rounding(nearest_);
      return;
    }
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec2 a = across_[c];
      const Vec2 b = across_[(c + 1) % 3];
      const Vec2 normal{b.y - a.y, a.x - b.x};
      const double size = length2(normal);
      const double distance = size > 0 ? std::abs(a.x * normal.x + a.y * normal.y) / size : 0;
      const double ratio = distance / rounding(normal);
      if (!(ratio < least)) continue;
      least = ratio;
      test.edge_distance = distance;
      test.rounding = rounding(normal);
    }
  }

  /// Between the ray and the triangle's normal, absolute; 0 for a triangle without area.
  double cosine() {
    const double size = length(plane().normal);
    return size > 0 ? std::abs(plane().facing) / size : 0;
  }

  /// Whether the ray's line meets it in one point. find_hit needs this.
  bool is_covered() {
    const Covering covering = certain_covering(across_, nearest_, double_error_);
    return covering == Covering::kUnknown ? exact().is_covered() : covering == Covering::kInside;
  }

  /// Sets `is_inside` and `exact_t`.
  void find_hit(TriangleTest& test) {
    if (const auto depth = certain_depth(q_, ray_.direction, plane(), double_error_)) {
      test.exact_t = {depth->lower / ray_.direction_length, depth->upper / ray_.direction_length};
      test.is_inside = test.exact_t.lower > ray_.tnear && test.exact_t.upper <= ray_.tfar;
      const bool is_beyond = test.exact_t.upper <= ray_.tnear || test.exact_t.lower > ray_.tfar;
      if (test.is_inside || is_beyond) return;
    }
    test.exact_t = exact_t();
    test.is_inside = exact().compare_t(ray_.given.tnear) > 0 && exact().compare_t(ray_.given.tfar) <= 0;
  }

  /// Sets what t can become.
  void find_t_bounds(TriangleTest& test) {
    const Vec3 direction = absolute(ray_.direction);
    const auto [nearest, farthest] = std::minmax_element(z_.begin(), z_.end());
    const double slack = std::abs(ray_.depth_on_axis(movement_)) + double_error_;
    const Interval corners{*nearest - slack - kRounding * std::abs(*nearest),
                           *farthest + slack + kRounding * std::abs(*farthest)};
    Interval bounds = corners;
    const Vec3 normal = absolute(plane().normal);
    const double turn = kRounding * dot(normal, direction);
    const double facing = std::abs(plane().facing) - turn;
    if (facing > 0) {
      const auto shift = [&](Interval depth) {
        const double size = std::max(std::abs(depth.lower), std::abs(depth.upper));
        return (dot(normal, movement_) + size * turn) / facing;
      };
      Interval depth = certain_depth(q_, ray_.direction, plane(), double_error_).value_or(corners);
      if (depth.upper - depth.lower > shift(depth) && exact().faces_ray()) {
        depth = exact_t();
        depth = {depth.lower * ray_.direction_length, depth.upper * ray_.direction_length};
      }
      bounds = {std::clamp(depth.lower - shift(depth), corners.lower, corners.upper),
                std::clamp(depth.upper + shift(depth), corners.lower, corners.upper)};
    }
    test.t_lower = bounds.lower / ray_.direction_length;
    test.t_upper = bounds.upper / ray_.direction_length;
  }

 private:
  /// How far a corner can move in the direction of `a`, of any length, across the ray.
  double rounding(Vec2 a) const {
    const double size = length2(a);
    if (size == 0) return length(movement_across_) + double_error_;
    const Vec3 direction = (a.x * ray_.across_x + a.y * ray_.across_y) * (1 / size);
    return dot(absolute(direction), movement_across_) + double_error_;
  }

  Interval exact_t() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double t = exact().t();
    if (t == 0) return {0, 0};
    return {std::nextafter(t, -kInfinity), std::nextafter(t, kInfinity)};
  }
  const ExactTriangle& exact() {
    if (!exact_) exact_.emplace(ray_.given, mesh_, prim_);
    return *exact_;
  }
  const Plane& plane() {
    if (!plane_) plane_.emplace(q_, ray_.direction);
    return *plane_;
  }

  const OracleRay& ray_;
  const Mesh& mesh_;
  std::size_t prim_;
  std::array<Vec3, 3> q_;  ///< corners as seen from the origin
  std::array<Vec2, 3> across_;
  std::array<double, 3> z_;  ///< distances along the ray, measured on its largest axis
  Vec2 nearest_;
  Vec3 movement_;         ///< of corners as seen from the origin, in each coordinate
  Vec3 movement_across_;  ///< the same where only the place across the ray counts
  double double_error_ = 0;
  std::optional<Plane> plane_;
  std::optional<ExactTriangle> exact_;
};

}  // namespace

OracleRay::OracleRay(const Ray& ray)
    : given(ray),
      origin(to_double(ray.origin)),
      direction(normalize(to_double(ray.direction))),
      axis(largest_axis(direction)),
      across_x(perpendicular(direction)),
      across_y(cross(direction, across_x)),
      direction_length(length(to_double(ray.direction))),
      origin_length(length(origin)),
      tnear(ray.tnear),
      tfar(ray.tfar) {}

double TriangleTest::edge_distance_ulps() const {
  return edge_distance == 0 ? 0 : edge_distance / rounding * kRoundingUlps;
}

bool is_answerable(const Ray& ray) {
  const auto is_finite = [](Vec3f p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  };
  const Vec3f d = ray.direction;
  return is_finite(ray.origin) && is_finite(d) && (d.x != 0 || d.y != 0 || d.z != 0) &&
         std::isfinite(ray.time) && !std::isnan(ray.tnear) && !std::isnan(ray.tfar);
}

TriangleMotion triangle_motion(const Mesh& mesh, float time) {
  TriangleMotion motion;
  motion.sample = motion_sample(mesh, time);
  motion.first_segment = motion.last_segment = motion.sample.segment;
  if (mesh.is_static()) return motion;
  const auto segments = static_cast<double>(mesh.segment_count());
  const TimeRange range = mesh.motion_range();
  const double begin = range.begin;
  const double magnitude = std::max(std::abs(begin), std::abs(static_cast<double>(time)));
  motion.ray_time_movement = kRounding * magnitude;
  if (mesh.has_step_times()) {
    reach_over_times(mesh, time, motion);
    return motion;
  }
  const double segment_length = (range.end - begin) / segments;
  motion.time_movement = motion.ray_time_movement / segment_length;
  const double f = motion.sample.fraction;
  if (f < motion.time_movement && motion.first_segment > 0) --motion.first_segment;
  if (f > 1 - motion.time_movement && motion.last_segment + 1 < mesh.segment_count()) ++motion.last_segment;
  return motion;
}

TriangleTest test_triangle(const OracleRay& ray, const Mesh& mesh, std::size_t prim,
                           const TriangleMotion& motion) {
  SeenTriangle triangle(ray, mesh, prim, motion);
  TriangleTest test;
  const bool is_covered = triangle.is_covered();
  triangle.find_edge(is_covered, test);
  if (is_covered) {
    triangle.find_hit(test);
    test.cosine = triangle.cosine();
  }
  test.needed_exact = triangle.needed_exact();
  const bool is_far_from_edges = std::abs(test.edge_distance) > test.rounding;
  if (!is_covered && is_far_from_edges) return test;
  triangle.find_t_bounds(test);
  test.is_certain =
      test.is_inside && is_far_from_edges && test.t_lower > ray.tnear && test.t_upper <= ray.tfar;
  test.is_possible = test.is_inside || (test.t_upper > ray.tnear && test.t_lower <= ray.tfar);
  return test;
}

}  // namespace stbvh::harness
