/// What double precision knows for certain of one ray and one triangle; the rest is for exact_triangle.h.
///
/// Let e = 2^-53, L = |p| + |o| + |q| the lengths of a position, of the ray's origin, and of a corner as seen
/// from it, and M the movement of the corners in 3 * 2^-23 of the time's magnitude. The corners as double
/// arithmetic sees them across the ray are wrong by less than
///   time:  (t - a) / (b - a) * S  4 roundings, 5 e u segments; u is at most twice the magnitude / segment
///   that
///          M is made of. A segment chosen wrongly lies this near: motion is continuous, and M knows the
///          speed of both.
///   p - o: lerp and difference    6 e (|p| + |o|)
///   frame across the ray          16 e |q|: ray.direction is within e of the true one, across_x within 6 e
///   of
///          a unit vector across it, across_y within 14 e
///   dot products                  3 e |q|
/// in each of two coordinates: less than 48 e L, which is a quarter of
///   error = 2^-24 (3 * 2^-23 L + M) = 192 e L (and for the time, 10 e against 192 e).
/// The other three quarters bear the roundings of what follows: an edge function of two corners s, s' is
/// wrong by at most a quarter of error (|s| + |s'| + error) through the corners, and 3 e |s| |s'| < error |s|
/// / 64 in itself; a dot product with the axis m by error |m| / 4 and 2 e |s| |m|.
///
/// Nothing underflows or overflows where it counts. A vertex or origin that is not 0 is at least 2^-149, so
/// error is at least 2^-195 and error^2 at least 2^-390, against 2^-1074 that an underflow may cost; if all
/// are 0 then so is error, and nothing is certain. Lengths are below 2^131, and no product has more than
/// four.
#pragma once

#include <array>
#include <optional>

#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// Of 3 * 2^-23 L + M: how far double arithmetic may misplace a corner, as derived above.
inline constexpr double kDoubleError = 0x1p-24;

enum class Covering { kOutside, kInside, kUnknown };

/// Whether the ray's line meets the closed triangle, corners as seen along the ray, which is at the origin.
/// `nearest` is the triangle's point nearest to the line, or any other point: it only helps to find an
/// answer.
Covering certain_covering(const std::array<Vec2, 3>& corners, Vec2 nearest, double error);

struct Interval {
  double lower = 0, upper = 0;
};

/// The plane of three corners as seen from the ray's origin, and how it stands to the unit vector
/// `direction`.
struct Plane {
  Plane(const std::array<Vec3, 3>& q, Vec3 direction);

  /// What the normal can turn by when each corner moves by `r`: an edge moves by at most 2 r.
  double turn(double r) const { return 2 * r * edges + 4 * r * r; }

  Vec3 normal;    ///< of no particular length
  double edges;   ///< lengths of two edges together
  double facing;  ///< normal . direction
};

/// Where along `direction` the ray meets the triangle, which it is known to do; empty where it is seen too
/// nearly from the side to tell.
///
/// The point found, X = T direction, is held against the true plane: T is wrong by n . (q_0 - X) / (n .
/// direction), all three true ones. The normal n is wrong by less than turn(error) / 2, with the cross
/// product's own 4 e |e1| |e2|; q_0 - X by less than error / 2; the quotient T leaves n . (q_0 - X) within
/// 15 e |n| |q| of 0, as |T| <= 2 |q| (else nothing is said). About half of the bound suffices for these; the
/// rest bears the bound's own roundings, and those of dividing the interval by the direction's length.
std::optional<Interval> certain_depth(const std::array<Vec3, 3>& q, Vec3 direction, const Plane& plane,
                                      double error);

}  // namespace stbvh::harness
