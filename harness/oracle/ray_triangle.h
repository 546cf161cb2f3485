/// One ray against one triangle: the exact answer, and how far it is from changing.
///
/// Exact: vertices, time and ray are floats, so whether the triangle is hit and at which t are well-defined.
/// The triangle is closed; a hit is one point of it with tnear < t <= tfar. Double precision decides where it
/// is certain (triangle_filter.h), integers of any length elsewhere (exact_triangle.h).
///
/// "Within rounding" has one meaning for all structures: the exact answer changes when each coordinate of the
/// vertices and of the ray's origin, each component of its direction, and its time move by at most
/// kRoundingUlps units in the last place of themselves (2^-23 of each one's magnitude): a coordinate that is
/// 0 does not move at all. The number is what a float computation of the contract cannot avoid (e = 2^-24,
/// the bound of one rounding), each written as a movement of what the computation started from, coordinate by
/// coordinate:
///
///   u = (t - a) / (b - a) * S             4 roundings of u:       time moves by 4 e max(|t|, |a|)
///   f = u - k                             exact
///   f = (t - t_k) / (t_(k+1) - t_k)       3 roundings of f:       time moves by 3 e (t - t_k), at most
///                                         (steps with times of their own) 3 e (|t| + |a|)
///   p = (1 - f) p_k + f p_(k+1)           1 - f, product, sum:    each vertex moves by 3 e |p|
///   q = p - o                             1 rounding:             vertex by e |p|, origin by e |o|
///   shear x - (d_x / d_z) z               ratio, product:         d_x moves by 2 e |d_x|
///                                         sum, of |x| + |x - x'|: vertex and origin by e, d_x by e |d_x|
///   edge function of two sheared corners  products, difference:   vertices move by 2 e (|p| + |o|)
///
/// So vertices and origin move by at most 6 e, time and direction by less: N = 3 units of 2^-23 covers each
/// line's sum. A structure that computes otherwise (absolute coordinates, products of three lengths) may need
/// more; what it then gets wrong beyond N counts as its error.
///
/// Each corner rounds for itself, though the ray is one. So a corner q moves, as seen from the origin, by
/// N (|p| + |o|) in each coordinate, and, where the ray passes it, across the ray by N |d_k / d_z| |q_z| more
/// (z: the ray's largest axis); along the ray the direction moves alike for all corners. From this:
///
///   across: the triangle and the ray's line stay apart if some direction n across the ray has all corners
///   farther along n than they move in n; the line stays inside if it is farther from each edge than that
///   edge's corners move across it.
///   along: a moved hit X' = T' d' is a mean of moved corners, which lie within m (one bound for each
///   coordinate) of the plane n . x = n . q_0 = T n . d. So n . (X' - m') = T n . d for some |m'| <= m, and
///     |T' - T| <= (sum |n_k| m_k + |T| sum |n_k| N |d_k|) / (|n . d| - sum |n_k| N |d_k|),
///   and T' d'_z lies between the least and the largest z of a corner, moved.
///
///   certain:  a hit however things move; possible: a hit for some movement.
#pragma once

#include <array>

#include "harness/oracle/triangle_filter.h"
#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/vec3.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

inline constexpr double kRoundingUlps = 3;
inline constexpr double kUlp = 0x1p-23;

/// A ray in double, with a frame across it. Meaningless unless the ray can hit anything at all.
struct OracleRay {
  explicit OracleRay(const Ray& ray);

  /// Of a vector: its component on the axis of the direction's largest one.
  double on_largest_axis(Vec3 a) const { return axis == 0 ? a.x : axis == 1 ? a.y : a.z; }
  /// How far along the ray it is at a point, seen from its origin, as told by that axis.
  double depth_on_axis(Vec3 q) const { return on_largest_axis(q) / on_largest_axis(direction); }

  Ray given;
  Vec3 origin;
  Vec3 direction;  ///< unit
  int axis;        ///< of the direction's largest component
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
  double ray_time_movement = 0;   ///< kRoundingUlps units of the time
  double time_movement = 0;       ///< the same in segments: of each of those below at most all of it
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
  double cosine = 0;                ///< between the ray and the normal, absolute; 0 without area
  double edge_distance = 0;         ///< to the nearest edge across the ray, negative outside
  double rounding = 0;              ///< how far corners move towards that edge

  /// Units in the last place that all must move by for the line to pass on the edge's other side; infinite
  /// where nothing can move that way.
  double edge_distance_ulps() const;
};

/// Tests triangle `prim`, which is valid, of `mesh`, which is visible at the time of the ray, which is
/// answerable.
TriangleTest test_triangle(const OracleRay& ray, const Mesh& mesh, std::size_t prim,
                           const TriangleMotion& motion);

}  // namespace stbvh::harness
