#include "harness/oracle/mesh_cull.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace stbvh::harness {
namespace {

constexpr std::size_t kLeafSize = 4;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Box3f merge(Box3f a, const Box3f& b) {
  extend(a, b.lower);
  extend(a, b.upper);
  return a;
}

float component(Vec3f p, std::size_t axis) {
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/// Shortens [enter, leave] to what lies in the slab; `ds` may be zero.
void clip(double origin, double direction, double lower, double upper, double& enter, double& leave) {
  if (direction == 0) {
    if (origin < lower || origin > upper) leave = -kInfinity;
    return;
  }
  const double a = (lower - origin) / direction;
  const double b = (upper - origin) / direction;
  enter = std::max(enter, std::min(a, b));
  leave = std::min(leave, std::max(a, b));
}

}  // namespace

MeshCull::MeshCull(const Mesh& mesh, bool split) {
  for (std::size_t prim = 0; prim < mesh.triangle_count(); ++prim) {
    if (is_valid_triangle(mesh, prim)) prims_.push_back(static_cast<std::uint32_t>(prim));
  }
  for (std::uint32_t prim : prims_) {
    for (const VertexBuffer& step : mesh.steps) {
      for (std::size_t c = 0; c < 3; ++c) {
        largest_ = std::max(largest_, length(to_double(step[mesh.indices[3 * prim + c]])));
      }
    }
  }
  if (!split) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    boxes_.assign(mesh.steps.size(), {Box3f{{-inf, -inf, -inf}, {inf, inf, inf}}});
    return;
  }
  while ((prims_.size() >> depth_) > kLeafSize) ++depth_;
  order_triangles(mesh, 0, 0);
  boxes_.assign(mesh.steps.size(), std::vector<Box3f>((std::size_t{2} << depth_) - 1, Box3f::empty()));
  tbb::parallel_for(std::size_t{0}, mesh.steps.size(), [&](std::size_t step) { bound(mesh, step); });
}

std::size_t MeshCull::first_of(std::size_t leaf) const {
  return leaf * prims_.size() >> depth_;
}

void MeshCull::order_triangles(const Mesh& mesh, std::size_t node, std::size_t depth) {
  if (depth == depth_) return;
  const std::size_t leaves = std::size_t{1} << (depth_ - depth);
  const std::size_t leaf = (node + 1 - (std::size_t{1} << depth)) * leaves;
  const auto at = [&](std::size_t l) { return prims_.begin() + static_cast<std::ptrdiff_t>(first_of(l)); };
  const VertexBuffer& middle = mesh.steps[mesh.steps.size() / 2];
  const auto corner = [&](std::uint32_t prim) { return middle[mesh.indices[3 * prim]]; };
  Box3f box = Box3f::empty();
  std::for_each(at(leaf), at(leaf + leaves), [&](std::uint32_t prim) { extend(box, corner(prim)); });
  std::size_t axis = 0;
  for (std::size_t a = 1; a < 3; ++a) {
    const auto extent = [&](std::size_t i) { return component(box.upper, i) - component(box.lower, i); };
    if (extent(a) > extent(axis)) axis = a;
  }
  std::nth_element(at(leaf), at(leaf + leaves / 2), at(leaf + leaves), [&](std::uint32_t a, std::uint32_t b) {
    return component(corner(a), axis) < component(corner(b), axis);
  });
  tbb::parallel_invoke([&] { order_triangles(mesh, 2 * node + 1, depth + 1); },
                       [&] { order_triangles(mesh, 2 * node + 2, depth + 1); });
}

void MeshCull::bound(const Mesh& mesh, std::size_t step) {
  std::vector<Box3f>& boxes = boxes_[step];
  const std::size_t first_leaf = (std::size_t{1} << depth_) - 1;
  for (std::size_t leaf = 0; leaf <= first_leaf; ++leaf) {
    for (std::size_t i = first_of(leaf); i < first_of(leaf + 1); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        extend(boxes[first_leaf + leaf], mesh.steps[step][mesh.indices[3 * prims_[i] + c]]);
      }
    }
  }
  for (std::size_t node = first_leaf; node-- > 0;) {
    boxes[node] = merge(boxes[2 * node + 1], boxes[2 * node + 2]);
  }
}

double MeshCull::padding(const OracleRay& ray, const TriangleMotion& motion) const {
  // More than test_triangle moves a corner by, on an axis or across the ray, and than `depth` in entry()
  // misses: coordinates are at most `largest`, a motion's twice that, a corner is at most
  // sqrt(3) (largest + |o|) along the ray.
  const double movement =
      kRoundingUlps * kUlp * 2 * (largest_ + ray.origin_length) + motion.time_movement * 2 * largest_;
  return 4 * movement;
}

double MeshCull::nearest(const OracleRay& ray, const TriangleMotion& motion) const {
  return prims_.empty() ? kPasses : entry(ray, motion, 0, padding(ray, motion));
}

double MeshCull::entry(const OracleRay& ray, const TriangleMotion& motion, std::size_t node,
                       double padding) const {
  const Box3f& begin = boxes_[motion.sample.segment][node];
  if (std::isinf(begin.upper.x)) return begin.upper.x > 0 ? -kInfinity : kPasses;
  const Box3f& end = boxes_[std::min(motion.sample.segment + 1, boxes_.size() - 1)][node];
  const double f = motion.sample.fraction;
  const Vec3 pad{padding, padding, padding};
  const Vec3 lower = lerp(to_double(begin.lower), to_double(end.lower), f) - pad;
  const Vec3 upper = lerp(to_double(begin.upper), to_double(end.upper), f) + pad;
  double enter = ray.tnear * ray.direction_length - padding;
  double leave = ray.tfar * ray.direction_length + padding;
  clip(ray.origin.x, ray.direction.x, lower.x, upper.x, enter, leave);
  clip(ray.origin.y, ray.direction.y, lower.y, upper.y, enter, leave);
  clip(ray.origin.z, ray.direction.z, lower.z, upper.z, enter, leave);
  if (!(enter <= leave)) return kPasses;
  // Not where the ray enters the box, but the box's own least depth: a grazed triangle's t_lower reaches down
  // to its nearest corner, as told by the ray's largest axis.
  const double depth = std::min(ray.depth_on_axis(lower - ray.origin), ray.depth_on_axis(upper - ray.origin));
  return depth / ray.direction_length;
}

}  // namespace stbvh::harness
