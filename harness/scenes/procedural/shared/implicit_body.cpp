#include "harness/scenes/procedural/shared/implicit_body.h"

#include <algorithm>
#include <limits>

namespace stbvh::harness {
namespace {

/// Polynomial smooth minimum: exactly min(a, b) where they differ by more than `k`.
double smooth_min(double a, double b, double k) {
  const double h = k - std::abs(a - b);
  return h > 0 ? std::min(a, b) - h * h / (4 * k) : std::min(a, b);
}

/// How quickly the influence of a joint falls with the distance from its blobs.
constexpr double kWeightFalloff = 0.018;

}  // namespace

double Blob::distance(Vec3 p) const {
  const bool is_round = scale.x == 1 && scale.y == 1 && scale.z == 1;  // most are: no divisions
  const auto shrink = [&](Vec3 v) {
    return is_round ? v : Vec3{v.x / scale.x, v.y / scale.y, v.z / scale.z};
  };
  const Vec3 q = shrink(p - a);
  const Vec3 axis = shrink(b - a);
  const double squared = dot(axis, axis);
  const double f = squared > 0 ? std::clamp(dot(q, axis) / squared, 0.0, 1.0) : 0.0;
  const double smallest = std::min({scale.x, scale.y, scale.z});
  return (length(q - axis * f) - lerp(radius_a, radius_b, f)) * smallest;
}

double ImplicitBody::distance(Vec3 p) const {
  double d = 1e3;
  for (const Blob& blob : blobs_) {
    d = blob.carve ? -smooth_min(-d, blob.distance(p), blob.blend)
                   : smooth_min(d, blob.distance(p), blob.blend);
  }
  return d;
}

ImplicitBody ImplicitBody::near(Vec3 center, double radius) const {
  double widest = 0;
  for (const Blob& blob : blobs_) widest = std::max(widest, blob.blend);
  ImplicitBody result;
  for (const Blob& blob : blobs_) {
    if (blob.distance(center) < 2 * radius + 2 * widest) result.add(blob);
  }
  return result;
}

Vec3 ImplicitBody::gradient(Vec3 p, double h) const {
  return Vec3{distance(p + Vec3{h, 0, 0}) - distance(p - Vec3{h, 0, 0}),
              distance(p + Vec3{0, h, 0}) - distance(p - Vec3{0, h, 0}),
              distance(p + Vec3{0, 0, h}) - distance(p - Vec3{0, 0, h})} *
         (0.5 / h);
}

SkinWeights ImplicitBody::weights(Vec3 p, const std::vector<std::size_t>& parents) const {
  std::vector<double> nearest(parents.size(), std::numeric_limits<double>::infinity());
  for (const Blob& blob : blobs_) {
    if (!blob.carve) nearest[blob.joint] = std::min(nearest[blob.joint], std::max(blob.distance(p), 0.0));
  }
  const auto main =
      static_cast<std::size_t>(std::min_element(nearest.begin(), nearest.end()) - nearest.begin());
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t j = 0; j < parents.size(); ++j) {
    if (j != main && parents[j] != main && parents[main] != j) continue;
    const double closeness = kWeightFalloff / (nearest[j] + kWeightFalloff);
    const double weight = std::pow(closeness, 3.0);
    if (weight > 1e-3) ranked.push_back({-weight, j});
  }
  std::sort(ranked.begin(), ranked.end());
  if (ranked.size() > 4) ranked.resize(4);
  double sum = 0;
  for (const auto& [weight, joint] : ranked) sum -= weight;
  SkinWeights result;
  for (std::size_t k = 0; k < ranked.size(); ++k) {
    result.joints[k] = static_cast<std::uint32_t>(ranked[k].second);
    result.weights[k] = -ranked[k].first / sum;
  }
  return result;
}

void ImplicitBody::bounds(Vec3& lower, Vec3& upper) const {
  constexpr double inf = std::numeric_limits<double>::infinity();
  lower = {inf, inf, inf};
  upper = {-inf, -inf, -inf};
  for (const Blob& blob : blobs_) {
    if (blob.carve) continue;
    const double r = std::max(blob.radius_a, blob.radius_b) + 0.5 * blob.blend;
    for (const Vec3 p : {blob.a, blob.b}) {
      lower = {std::min(lower.x, p.x - r), std::min(lower.y, p.y - r), std::min(lower.z, p.z - r)};
      upper = {std::max(upper.x, p.x + r), std::max(upper.y, p.y + r), std::max(upper.z, p.z + r)};
    }
  }
}

}  // namespace stbvh::harness
