#include "harness/oracle/triangle_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "harness/oracle/exact_triangle.h"

namespace stbvh::harness {
namespace {

double length2(Point2 a) {
  return std::sqrt(a.x * a.x + a.y * a.y);
}

/// The point of the line segment a b that is nearest to the origin.
Point2 nearest_on_edge(Point2 a, Point2 b) {
  const Point2 e{b.x - a.x, b.y - a.y};
  const double squared = e.x * e.x + e.y * e.y;
  const double along = squared > 0 ? std::clamp(-(a.x * e.x + a.y * e.y) / squared, 0.0, 1.0) : 0.0;
  return {a.x + along * e.x, a.y + along * e.y};
}

/// The point of the triangle's edges that is nearest to the origin.
Point2 nearest_on_edges(const std::array<Point2, 3>& s) {
  return std::min({nearest_on_edge(s[0], s[1]), nearest_on_edge(s[1], s[2]), nearest_on_edge(s[2], s[0])},
                  [](Point2 a, Point2 b) { return a.x * a.x + a.y * a.y < b.x * b.x + b.y * b.y; });
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

/// One triangle as seen along a ray; asks exact arithmetic where double precision cannot tell.
class SeenTriangle {
 public:
  SeenTriangle(const OracleRay& ray, const Mesh& mesh, std::size_t prim, const TriangleMotion& motion)
      : ray_(ray), mesh_(mesh), prim_(prim), q_(triangle_at(mesh, prim, motion.sample)) {
    for (std::size_t c = 0; c < 3; ++c) {
      q_[c] = q_[c] - ray.origin;
      across_[c] = {dot(q_[c], ray.across_x), dot(q_[c], ray.across_y)};
    }
    nearest_ = nearest_on_edges(across_);
    rounding_ = movement(ray, mesh, prim, motion, q_);
  }

  double rounding() const { return rounding_; }
  double edge_distance() const { return length2(nearest_); }
  bool needed_exact() const { return exact_.has_value(); }

  /// Whether the ray's line meets it in one point. The next two need this.
  bool is_covered() {
    const Covering covering = certain_covering(across_, nearest_, kDoubleError * rounding_);
    return covering == Covering::kUnknown ? exact().is_covered() : covering == Covering::kInside;
  }

  /// Sets `is_inside` and `exact_t`.
  void find_hit(TriangleTest& test) {
    if (const auto depth = certain_depth(q_, ray_.direction, plane(), kDoubleError * rounding_)) {
      test.exact_t = {depth->lower / ray_.direction_length, depth->upper / ray_.direction_length};
      test.is_inside = test.exact_t.lower > ray_.tnear && test.exact_t.upper <= ray_.tfar;
      const bool is_beyond = test.exact_t.upper <= ray_.tnear || test.exact_t.lower > ray_.tfar;
      if (test.is_inside || is_beyond) return;
    }
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double t = exact().t();
    test.exact_t = {std::nextafter(t, -kInfinity), std::nextafter(t, kInfinity)};
    test.is_inside = exact().compare_t(ray_.given.tnear) > 0 && exact().compare_t(ray_.given.tfar) <= 0;
  }

  /// Sets what t can become when the corners move by `rounding`, around the middle of `exact_t` if it is
  /// covered.
  void find_t_bounds(bool is_covered, TriangleTest& test) {
    const std::array<double, 3> depth{dot(q_[0], ray_.direction), dot(q_[1], ray_.direction),
                                      dot(q_[2], ray_.direction)};
    const auto [nearest, farthest] = std::minmax_element(depth.begin(), depth.end());
    double lower = *nearest - rounding_;
    double upper = *farthest + rounding_;
    // With the edges the normal moves; the plane moves by `rounding` along it.
    const double turn = plane().turn(rounding_);
    const double facing = std::abs(plane().facing);
    if (is_covered && facing > turn) {
      const double shift = rounding_ * (length(plane().normal) + turn) / (facing - turn);
      const double middle = (test.exact_t.lower + test.exact_t.upper) / 2 * ray_.direction_length;
      lower = std::max(lower, middle - shift);
      upper = std::min(upper, middle + shift);
    }
    const double scale = kRoundingUlps * kUlp;  // the length of the direction moves too
    test.t_lower = (lower - scale * std::abs(lower)) / ray_.direction_length;
    test.t_upper = (upper + scale * std::abs(upper)) / ray_.direction_length;
  }

 private:
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
  std::array<Point2, 3> across_;
  Point2 nearest_;
  double rounding_ = 0;
  std::optional<Plane> plane_;
  std::optional<ExactTriangle> exact_;
};

}  // namespace

OracleRay::OracleRay(const Ray& ray)
    : given(ray),
      origin(to_double(ray.origin)),
      direction(normalize(to_double(ray.direction))),
      across_x(perpendicular(direction)),
      across_y(cross(direction, across_x)),
      direction_length(length(to_double(ray.direction))),
      origin_length(length(origin)),
      tnear(ray.tnear),
      tfar(ray.tfar) {}

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
  SeenTriangle triangle(ray, mesh, prim, motion);
  TriangleTest test;
  test.rounding = triangle.rounding();
  const bool is_covered = triangle.is_covered();
  const double distance = triangle.edge_distance();
  test.edge_distance = is_covered ? distance : -distance;
  if (is_covered) triangle.find_hit(test);
  test.needed_exact = triangle.needed_exact();
  if (!is_covered && distance > test.rounding) return test;
  triangle.find_t_bounds(is_covered, test);
  test.is_certain =
      test.is_inside && distance > test.rounding && test.t_lower > ray.tnear && test.t_upper <= ray.tfar;
  test.is_possible = test.is_inside || (test.t_upper > ray.tnear && test.t_lower <= ray.tfar);
  return test;
}

}  // namespace stbvh::harness
