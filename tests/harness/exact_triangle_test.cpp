/// Exact and filtered answers against rational arithmetic with other formulas, on random triangles that are
/// made to be hard.
#include "harness/oracle/exact_triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "harness/oracle/oracle.h"
#include "harness/oracle/ray_triangle.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

using RationalVec3 = std::array<mpq_class, 3>;

RationalVec3 rational(Vec3f p) {
  return {mpq_class(p.x), mpq_class(p.y), mpq_class(p.z)};
}
RationalVec3 minus(const RationalVec3& a, const RationalVec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
mpq_class dot_of(const RationalVec3& a, const RationalVec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
RationalVec3 cross_of(const RationalVec3& a, const RationalVec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct RationalHit {
  bool is_covered = false;
  mpq_class t, u, v;

  bool is_beyond(float bound) const { return std::isinf(bound) ? bound < 0 : t > mpq_class(bound); }
};

RationalVec3 rational_position(const Mesh& mesh, std::uint32_t vertex, float time) {
  if (mesh.is_static()) return rational(mesh.steps[0][vertex]);
  std::size_t k = 0;
  mpq_class f;
  if (mesh.has_step_times()) {
    while (k + 1 < mesh.segment_count() && time >= mesh.step_times[k + 1]) ++k;
    const mpq_class begin(mesh.step_times[k]);
    f = (mpq_class(time) - begin) / (mpq_class(mesh.step_times[k + 1]) - begin);
  } else {
    const mpq_class a(mesh.time_range.begin);
    const mpq_class u = (mpq_class(time) - a) / (mpq_class(mesh.time_range.end) - a) * mesh.segment_count();
    while (k + 1 < mesh.segment_count() && u >= k + 1) ++k;
    f = u - k;
  }
  const RationalVec3 begin = rational(mesh.steps[k][vertex]);
  const RationalVec3 end = rational(mesh.steps[k + 1][vertex]);
  RationalVec3 p;
  for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = (1 - f) * begin[axis] + f * end[axis];
  return p;
}

/// o + t d = p0 + u e1 + v e2 by Cramer's rule.
RationalHit rational_hit(const Ray& ray, const Mesh& mesh, std::size_t prim = 0) {
  const std::uint32_t* index = &mesh.indices[3 * prim];
  const RationalVec3 p0 = rational_position(mesh, index[0], ray.time);
  const RationalVec3 e1 = minus(rational_position(mesh, index[1], ray.time), p0);
  const RationalVec3 e2 = minus(rational_position(mesh, index[2], ray.time), p0);
  const RationalVec3 s = minus(rational(ray.origin), p0);
  const RationalVec3 d = rational(ray.direction);
  const RationalVec3 h = cross_of(d, e2);
  const RationalVec3 q = cross_of(s, e1);
  const mpq_class determinant = dot_of(e1, h);
  if (determinant == 0) return {};
  RationalHit hit{
      .t = dot_of(e2, q) / determinant, .u = dot_of(s, h) / determinant, .v = dot_of(d, q) / determinant};
  hit.is_covered = hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1;
  return hit;
}

/// Triangles and rays that meet at corners, at edges, from the side, at the ends of the ray, or next to it.
class HardCases {
 public:
  explicit HardCases(std::uint64_t seed) : random_(seed) {}

  Mesh mesh() {
    scale_ = std::ldexp(1.0, static_cast<int>(random_.next() % 101) - 60);
    offset_ = random_.next() % 3 == 0 ? 1e6 : 0;
    const std::size_t steps = 1 + random_.next() % 4;
    Mesh mesh;
    mesh.indices = {0, 1, 2};
    if (random_.next() % 2 == 0) mesh.time_range = {0.1f, 0.9f};
    for (std::size_t k = 0; k < steps; ++k) {
      VertexBuffer& step = mesh.steps.emplace_back(3);
      for (std::size_t c = 0; c < 3; ++c) step[c] = to_float(point() * scale_);
      if (random_.next() % 8 == 0)
        step[2] = nudged(to_float((to_double(step[0]) + to_double(step[1])) * 0.5));
    }
    if (steps > 1 && random_.next() % 2 == 0) mesh.step_times = uneven_times(mesh);
    return mesh;
  }

  Ray ray(const Mesh& mesh) {
    const std::size_t segments = mesh.segment_count();
    const TimeRange range = mesh.motion_range();
    const double grid = segments > 0 ? mesh.step_time(random_.next() % (segments + 1)) : range.begin;
    const double time = random_.next() % 2 == 0 ? grid : random_.uniform(range.begin, range.end);
    Ray ray{};
    ray.mask = 0xFFFFFFFFu;
    ray.time = std::clamp(static_cast<float>(time), range.begin, range.end);
    const auto corners = triangle_at(mesh, 0, motion_sample(mesh, ray.time));
    const double u = weight();
    const double v = weight() * (1 - u);
    const Vec3 target = corners[0] * (1 - u - v) + corners[1] * u + corners[2] * v;
    ray.origin = nudged(to_float(point() * scale_));
    ray.direction = nudged(to_float(target - to_double(ray.origin)));
    if (random_.next() % 4 == 0) ray.direction = to_float(to_double(ray.direction) * 0x1p-20);
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.tnear = -ray.tfar;
    return ray;
  }

  /// An interval that ends at or next to `t`.
  void end_near(double t, Ray& ray) {
    const float end = nudged({static_cast<float>(t), 0, 0}).x;
    (random_.next() % 2 == 0 ? ray.tnear : ray.tfar) = end;
  }

 private:
  /// Anywhere in the mesh's time range, or one float apart.
  std::vector<float> uneven_times(const Mesh& mesh) {
    std::vector<float> times{mesh.time_range.begin};
    const float part = (mesh.time_range.end - times[0]) / static_cast<float>(mesh.segment_count());
    while (times.size() < mesh.steps.size()) {
      const bool is_next = times.back() > 0 && random_.next() % 3 == 0;
      times.push_back(is_next ? std::nextafter(times.back(), 2.0f)
                              : times.back() + part * static_cast<float>(random_.uniform(0.01, 1)));
    }
    return times;
  }
  Vec3 point() {
    const auto coordinate = [&] { return static_cast<double>(random_.next() % 9) - 4 + offset_; };
    const double x = coordinate();
    const double y = coordinate();
    return {x, y, coordinate()};
  }
  double weight() {
    constexpr double kWeights[] = {0, 0, 0.5, 1};
    return random_.next() % 4 == 0 ? random_.uniform() : kWeights[random_.next() % 4];
  }
  Vec3f nudged(Vec3f p) {
    for (float* x : {&p.x, &p.y, &p.z}) {
      const std::uint32_t way = random_.next() % 6;
      if (way < 2) *x = std::nextafter(*x, way == 0 ? 1e30f : -1e30f);
    }
    return p;
  }

  Pcg32 random_;
  double scale_ = 1;
  double offset_ = 0;
};

void expect_nearest_double(double x, const mpq_class& exact) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const mpq_class error = abs(mpq_class(x) - exact);
  EXPECT_LE(error, abs(mpq_class(std::nextafter(x, kInfinity)) - exact));
  EXPECT_LE(error, abs(mpq_class(std::nextafter(x, -kInfinity)) - exact));
}

/// `needed_exact` counts where double precision did not suffice.
void expect_right(const Ray& ray, const Mesh& mesh, std::size_t& needed_exact) {
  const TriangleTest test = test_triangle(OracleRay(ray), mesh, 0, triangle_motion(mesh, ray.time));
  needed_exact += test.needed_exact ? 1 : 0;
  const RationalHit hit = rational_hit(ray, mesh);
  const bool is_inside = hit.is_covered && hit.is_beyond(ray.tnear) && !hit.is_beyond(ray.tfar);
  ASSERT_EQ(test.is_inside, is_inside);
  ASSERT_EQ(!std::signbit(test.edge_distance), hit.is_covered);
  const ExactTriangle exact(ray, mesh, 0);
  ASSERT_EQ(exact.is_covered(), hit.is_covered);
  if (!hit.is_covered) return;
  ASSERT_EQ(exact.compare_t(ray.tnear) > 0, hit.is_beyond(ray.tnear));
  ASSERT_EQ(exact.compare_t(ray.tfar) > 0, hit.is_beyond(ray.tfar));
  expect_nearest_double(exact.t(), hit.t);
  expect_nearest_double(exact.u(), hit.u);
  expect_nearest_double(exact.v(), hit.v);
  EXPECT_LE(mpq_class(test.exact_t.lower), hit.t);
  EXPECT_GE(mpq_class(test.exact_t.upper), hit.t);
  if (!is_inside) return;
  EXPECT_TRUE(test.is_possible);
  EXPECT_LE(mpq_class(test.t_lower), hit.t);
  EXPECT_GE(mpq_class(test.t_upper), hit.t);
}

TEST(ExactTriangle, AgreesWithRationalArithmeticWhereverDoubleDecides) {
  HardCases cases(11);
  std::size_t tests = 0;
  std::size_t needed_exact = 0;
  for (int i = 0; i < 20000 && !HasFatalFailure(); ++i) {
    const Mesh mesh = cases.mesh();
    Ray ray = cases.ray(mesh);
    if (!is_answerable(ray)) continue;
    ++tests;
    expect_right(ray, mesh, needed_exact);
    const ExactTriangle exact(ray, mesh, 0);
    if (!exact.is_covered()) continue;
    cases.end_near(exact.t(), ray);
    ++tests;
    expect_right(ray, mesh, needed_exact);
  }
  EXPECT_GT(needed_exact, tests / 10);
  EXPECT_GT(tests - needed_exact, tests / 10);
}

TEST(ExactTriangle, OracleFindsTheNearestOfAll) {
  const Scene scene = mixed_step_scene(40);
  const Oracle oracle(scene);
  Pcg32 random(13);
  std::size_t at_corner = 0;
  for (int i = 0; i < 300; ++i) {
    // At a corner, along an axis: the ray passes through it exactly.
    const Mesh& target = scene.meshes[random.next() % scene.meshes.size()];
    const std::size_t step = random.next() % target.steps.size();
    const Vec3f corner = target.steps[step][random.next() % target.steps[step].size()];
    Ray ray = ray_along_z(corner.x, corner.y, i % 2 == 0 ? 0.5f : static_cast<float>(random.uniform()));
    ray.origin.z = -10;
    std::vector<OraclePrimitive> nearest;
    std::optional<mpq_class> least;
    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
      if (!is_visible_at(scene.meshes[m], ray.time)) continue;
      for (std::uint32_t prim = 0; prim < scene.meshes[m].triangle_count(); ++prim) {
        const RationalHit hit = rational_hit(ray, scene.meshes[m], prim);
        if (!hit.is_covered || !hit.is_beyond(ray.tnear) || hit.is_beyond(ray.tfar)) continue;
        if (least && hit.t > *least) continue;
        if (!least || hit.t < *least) nearest.clear();
        least = hit.t;
        nearest.push_back({m, prim});
      }
    }
    const OracleAnswer answer = oracle.answer(ray);
    ASSERT_EQ(answer.nearest, nearest);
    ASSERT_EQ(answer.is_hit, least.has_value());
    if (least) expect_nearest_double(answer.t, *least);
    at_corner += answer.is_hit && answer.edge_distance_ulps < 1e-6 ? 1 : 0;
  }
  EXPECT_GT(at_corner, 20u);
}

TEST(ExactTriangle, OrdersTrianglesByT) {
  HardCases cases(12);
  std::size_t same = 0;
  std::size_t different = 0;
  for (int i = 0; i < 3000; ++i) {
    const Mesh a = cases.mesh();
    const Ray ray = cases.ray(a);
    Mesh b = a;
    std::swap(b.indices[0], b.indices[1 + static_cast<std::size_t>(i) % 2]);
    if (i % 3 == 0) b.steps[0][2].z = std::nextafter(b.steps[0][2].z, 1e30f);
    const RationalHit hit_a = rational_hit(ray, a);
    const RationalHit hit_b = rational_hit(ray, b);
    if (!hit_a.is_covered || !hit_b.is_covered) continue;
    const int order = cmp(hit_a.t, hit_b.t);
    const int found = ExactTriangle(ray, a, 0).compare_t(ExactTriangle(ray, b, 0));
    EXPECT_EQ(std::clamp(found, -1, 1), std::clamp(order, -1, 1));
    ++(order == 0 ? same : different);
  }
  EXPECT_GT(different, 100u);
  EXPECT_GT(same, 300u);
}

}  // namespace
}  // namespace stbvh::harness
