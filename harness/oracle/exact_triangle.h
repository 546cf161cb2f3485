/// One ray against one triangle in exact integer arithmetic, without any rounding.
///
/// Vertices, times and rays are floats, each an integer times a power of two; so all below are integers times
/// a common power of two, which drops out of every sign. With [a, b] the mesh's time range, S its segments, t
/// the ray's time and k = min(floor((t - a) S / (b - a)), S - 1):
///
///   Q_c = (b - a) (p_k - o) + ((t - a) S - k (b - a)) (p_(k+1) - p_k)    the corner as seen from the origin,
///                                                                        times b - a
///   W_0 = d . (Q_1 x Q_2), W_1 = d . (Q_2 x Q_0), W_2 = d . (Q_0 x Q_1)  edge functions; W_0 + W_1 + W_2 =
///                                                                        d . n, n the plane's normal
///   t = Q_0 . (Q_1 x Q_2) / ((b - a) d . n), u = W_1 / d . n, v = W_2 / d . n
///
/// With steps at times of their own k is the last segment that has begun, t_(k+1) - t_k stands for b - a, and
/// t - t_k for (t - a) S - k (b - a). A mesh that stands still has b - a = 1 and Q_c = p_0 - o.
#pragma once

#include <gmpxx.h>

#include <array>
#include <cstddef>

#include "harness/scenes/scene.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

class ExactTriangle {
 public:
  /// Origin, direction and time of `ray` are finite; `prim` is a valid triangle of `mesh`, which is visible
  /// at the ray's time.
  ExactTriangle(const Ray& ray, const Mesh& mesh, std::size_t prim);

  /// Whether the ray's line meets the triangle's plane in one point. All below needs this.
  bool faces_ray() const { return sgn(facing_) != 0; }

  /// Whether the ray's line meets the triangle, its edges and corners included, and does so in one point:
  /// never so for a triangle without area, or one that the line lies in the plane of.
  bool is_covered() const;

  /// Sign of t - bound; `bound` may be infinite, but not NaN.
  int compare_t(float bound) const;
  /// Sign of t - other's t, for another triangle and the same ray.
  int compare_t(const ExactTriangle& other) const;

  /// The doubles nearest to t and to the barycentric coordinates, point = (1 - u - v) p0 + u p1 + v p2.
  double t() const;
  double u() const;
  double v() const;

 private:
  std::array<mpz_class, 3> weights_;  ///< W_0, W_1, W_2
  mpz_class facing_;                  ///< their sum
  /// t = numerator / denominator * 2^exponent; the denominator is not negative.
  mpz_class numerator_, denominator_;
  long exponent_ = 0;
};

}  // namespace stbvh::harness
