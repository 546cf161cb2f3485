/// One ray against one triangle: the exact answer, and how far it is from changing.
///
/// Exact: vertices, time and ray are floats, so whether the triangle is hit and at which t are well-defined.
/// The triangle is closed; a hit is one point of it with tnear < t <= tfar. Double precision decides where it
/// is certain (triangle_filter.h), integers of any length elsewhere (exact_triangle.h).
///
/// "Within rounding" has one meaning for all structures: the exact answer changes when the ray's origin and
/// direction, its time and the vertices move by at most kRoundingUlps units in the last place (2^-23 of each
/// one's magnitude). The number is what a float computation of the contract cannot avoid, in halves of a unit
/// (e = 2^-24, the bound of one rounding), each written as a movement of what the computation started from:
///
///   u = (t - a) / (b - a) * S             4 roundings of u:       time moves by 4 e |t|
///   f = u - k                             exact
///   p = (1 - f) p_k + f p_(k+1)           1 - f, product, sum:    vertices move by 3 e |p|
///   q = p - o                             1 rounding:             vertex and origin move by e (|p| + |o|)
///   shear of q along the direction        ratio, product, sum:    direction moves by 3 e
///   edge function of two sheared corners  products, difference:   vertices move by 2 e (|p| + |o|)
///
/// So vertices and origin move by at most 6 e, time and direction by less: N = 3 units of 2^-23 covers each
/// line's sum. A structure that computes otherwise (absolute coordinates, products of three lengths) may need
/// more; what it then gets wrong beyond N counts as its error.
///
/// In the plane across the ray a corner that moves so stays in a disc of radius r (`rounding`), so
///   certain:  the ray's point lies inside the triangle, farther than r from each edge: a hit however things
///   move; possible: it lies inside, or not farther than r from the triangle: a hit for some movement.
#pragma once

#include <array>

#include "harness/oracle/triangle_filter.h"
#include "harness/rays/ray_set.h"
#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

inline constexpr double kRoundingUlps = 3;
inline constexpr double kUlp = 0x1p-23;

/// A ray in double, with a frame across it. Meaningless unless the ray can hit anything at all.
struct OracleRay {
  explicit OracleRay(const Ray& ray);

  Ray given;
  Vec3 origin;
  Vec3 direction;  ///< unit
  Vec3 across_x, across_y;
  double direction_length;  ///< of the ray's own direction: t is in its units
  double origin_length;
  double tnear, tfar;
};

/// Whether `ray` can hit anything: origin, direction and time are finite, the direction is not zero, no end
/// of its interval is NaN.
bool is_answerable(const Ray& ray);

/// What can move a triangle of a mesh at the ray's time.
struct TriangleMotion {
  MotionSample sample;
  double time_movement = 0;       ///< in segments, for kRoundingUlps
  std::size_t first_segment = 0;  ///< segments that the time may fall into, moved so far
  std::size_t last_segment = 0;
};

TriangleMotion triangle_motion(const Mesh& mesh, float time);

struct TriangleTest {
  bool is_inside = false;           ///< the exact answer
  bool needed_exact = false;        ///< double precision could not tell
  bool is_certain = false;          ///< a hit however things move
  bool is_possible = false;         ///< a hit for some movement
  Interval exact_t;                 ///< the exact hit's t lies in it, where is_inside
  double t_lower = 0, t_upper = 0;  ///< what t can become
  double edge_distance = 0;         ///< to the nearest edge across the ray, negative outside
  double rounding = 0;              ///< r above

  /// Units in the last place that all must move by for the answer to change.
  double edge_distance_ulps() const { return edge_distance / rounding * kRoundingUlps; }
};

/// Tests triangle `prim`, which is valid, of `mesh`, which is visible at the time of the ray, which is
/// answerable.
TriangleTest test_triangle(const OracleRay& ray, const Mesh& mesh, std::size_t prim,
                           const TriangleMotion& motion);

}  // namespace stbvh::harness
