/// Ray against a leaf of up to eight triangles over up to eight vertices, watertight.
///
/// The test of Woop, Benthin and Wald (JCGT 2013), split in two. For all eight triangles at once, in float
/// and without fma: a product rounded to float is monotone, so a difference of two products has the right
/// sign or is zero, and a triangle whose edge functions have both signs is missed for certain. What is left
/// over is decided in double, where the products are exact, and the difference of two keeps its sign: edge
/// functions of the two triangles of an edge are exactly opposite. Both see the same vertices: interpolated
/// once for each vertex, always alike.
#pragma once

#include <cmath>
#include <limits>

#include "traverse/leaf_vertices.inl"
#include "traverse/slabs.inl"

namespace stbvh {
namespace {

struct WatertightTest : PaddedSlabs {
  static constexpr bool kFindDecides = false;

  /// Candidates of one leaf, in memory for the scalar part.
  struct Candidates {
    alignas(32) float x[kWidth], y[kWidth];  ///< sheared: the ray is at (0, 0)
    alignas(32) float axis[3][kWidth];       ///< relative to the origin, order (kx, ky, kz)
    bool is_certain = false;  ///< one of them is hit within the ray's range, whatever is rounded
  };

  // Vertices, axes in the order (kx, ky, kz) ---------------------------------------------------------------

  static F32x8 relative(const float* position, F32x8 origin) { return load(position) - origin; }

  /// (1 - f) * p_k + f * p_{k+1}; the origin is taken off first, before anything could cancel.
  static LeafVertices interpolated(const TraversalRay& ray, const StepVertices& v0, const StepVertices& v1,
                                   float f) {
    const F32x8 f0 = splat(1.0f - f);
    const F32x8 f1 = splat(f);
    const auto axis = [&](int k) {
      const F32x8 origin = splat(ray.origin[k]);
      return f0 * relative(v0.position[k], origin) + f1 * relative(v1.position[k], origin);
    };
    return {axis(ray.kx), axis(ray.ky), axis(ray.kz)};
  }

  static LeafVertices at_rest(const TraversalRay& ray, const StepVertices& v) {
    const auto axis = [&](int k) { return relative(v.position[k], splat(ray.origin[k])); };
    return {axis(ray.kx), axis(ray.ky), axis(ray.kz)};
  }

  // Triangles ---------------------------------------------------------------------------------------------

  /// Bits of the triangles that may be hit; `c` is filled if there are any. With kAnyHit, also whether one of
  /// them is hit for certain: its edge functions have one sign, none is zero, and all its vertices are so far
  /// along the ray that the hit is in the ray's range.
  template <bool kAnyHit>
  static unsigned find(const TraversalRay& ray, const LeafHeader& leaf, const LeafVertices& p,
                       Candidates& c) {
    const F32x8 x = p.x - splat(ray.shear_x) * p.z;
    const F32x8 y = p.y - splat(ray.shear_y) * p.z;
    const Slots8 slot_a = load_slots(leaf.corners[0]);
    const Slots8 slot_b = load_slots(leaf.corners[1]);
    const Slots8 slot_c = load_slots(leaf.corners[2]);
    const F32x8 ax = permute(x, slot_a), ay = permute(y, slot_a);
    const F32x8 bx = permute(x, slot_b), by = permute(y, slot_b);
    const F32x8 cx = permute(x, slot_c), cy = permute(y, slot_c);
    const F32x8 wa = cx * by - cy * bx;
    const F32x8 wb = ax * cy - ay * cx;
    const F32x8 wc = bx * ay - by * ax;
    const F32x8 lowest = min(min(wa, wb), wc);
    const F32x8 highest = max(max(wa, wb), wc);
    const unsigned triangles = (1u << leaf.triangle_count) - 1;
    const unsigned bits = ~straddles_zero(lowest, highest).bits & triangles;
    if (bits == 0) return 0;
    if (kAnyHit) {
      const F32x8 distance = p.z * splat(ray.sign_z);
      const F32x8 da = permute(distance, slot_a);
      const F32x8 db = permute(distance, slot_b);
      const F32x8 dc = permute(distance, slot_c);
      const unsigned inside = less(splat(ray.certain_near), min(min(da, db), dc)).bits &
                              less(max(max(da, db), dc), splat(ray.certain_far)).bits;
      const F32x8 zero = splat(0.0f);
      c.is_certain = ((less(zero, lowest).bits | less(highest, zero).bits) & inside & bits) != 0;
      if (c.is_certain) return bits;
    }
    store(c.x, x);
    store(c.y, y);
    store(c.axis[0], p.x);
    store(c.axis[1], p.y);
    store(c.axis[2], p.z);
    return bits;
  }

  // The distance -------------------------------------------------------------------------------------------

  static double least(double a, double b) { return a < b ? a : b; }
  static double greatest(double a, double b) { return a > b ? a : b; }

  struct Range {
    double lower, upper;

    static Range of(double a, double b, double c) {
      return {least(least(a, b), c), greatest(greatest(a, b), c)};
    }
    double size() const { return greatest(std::fabs(lower), std::fabs(upper)); }
  };

  /// A triangle as it stands to the ray, in double: corners relative to the origin, and their plane. The
  /// floats that these are made of are exact, so what rounds is 2^-53 of the triangle's size, not 2^-24 of
  /// it.
  struct Plane {
    double origin[3], direction[3];  ///< of the ray
    double corners[3][3];            ///< of each axis: a, b, c
    double normal[3];                ///< cross(b - a, c - a)
    double distance;                 ///< from the origin, times the normal's length
    double facing;                   ///< normal . direction

    Plane(const Ray& ray, const LeafHeader& leaf, const LeafMotion& motion, unsigned triangle)
        : origin{ray.origin.x, ray.origin.y, ray.origin.z},
          direction{ray.direction.x, ray.direction.y, ray.direction.z} {
      const double f1 = motion.fraction, f0 = 1.0 - f1;
      double e1[3], e2[3];
      for (int k = 0; k < 3; ++k) {
        const double o = origin[k];
        for (int i = 0; i < 3; ++i) {
          const std::uint8_t slot = leaf.corners[i][triangle];
          const double from = motion.begin->position[k][slot], to = motion.end->position[k][slot];
          corners[k][i] = f0 * (from - o) + f1 * (to - o);
        }
        e1[k] = corners[k][1] - corners[k][0];
        e2[k] = corners[k][2] - corners[k][0];
      }
      normal[0] = e1[1] * e2[2] - e1[2] * e2[1];
      normal[1] = e1[2] * e2[0] - e1[0] * e2[2];
      normal[2] = e1[0] * e2[1] - e1[1] * e2[0];
      distance = normal[0] * corners[0][0] + normal[1] * corners[1][0] + normal[2] * corners[2][0];
      facing = normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2];
    }

    /// Whether the plane passes the ray's origin as near as floats tell: it meets the point if each of its
    /// coordinates moves by 3 units in the last place.
    bool holds_origin() const {
      const double size = std::fabs(normal[0] * origin[0]) + std::fabs(normal[1] * origin[1]) +
                          std::fabs(normal[2] * origin[2]);
      return std::fabs(distance) <= 3 * 0x1p-23 * size;
    }

    /// The t at which the ray is within the triangle's own bounds, widened by what the boxes above are padded
    /// for: no box hides what lies there.
    Range within_bounds() const {
      double reach = 0.0;
      for (const auto& axis : corners) reach = greatest(reach, Range::of(axis[0], axis[1], axis[2]).size());
      const double slack = 0x1p-21 * reach;
      Range range{-kInfinity, kInfinity};
      for (int k = 0; k < 3; ++k) {
        if (direction[k] == 0.0) continue;
        const Range bounds = Range::of(corners[k][0], corners[k][1], corners[k][2]);
        const double first = (bounds.lower - slack) / direction[k];
        const double second = (bounds.upper + slack) / direction[k];
        range.lower = greatest(range.lower, least(first, second));
        range.upper = least(range.upper, greatest(first, second));
      }
      return range;
    }
  };

  /// The t of a hit on a triangle that the origin is near to, against its size. Weighing the corners loses
  /// it: their floats round by their own distances. It is where the plane is met. `weighted` is the t that
  /// weighing gives, `corners` those of the corners as the edge functions see them, along the largest axis.
  ///
  /// It takes the query's ray, for the traversal's own must not have an address: that costs a tenth of its
  /// speed.
  [[gnu::noinline]] static double t_of_plane(const Ray& ray, const LeafHeader& leaf, const MeshRecord& mesh,
                                             unsigned triangle, Range corners, double weighted) {
    LeafMotion motion;
    load_motion(ray.time, leaf, mesh, motion);
    const Plane plane(ray, leaf, motion, triangle);
    Range range = plane.within_bounds();
    range.lower = greatest(range.lower, corners.lower - 0x1p-22 * std::fabs(corners.lower));
    range.upper = least(range.upper, corners.upper + 0x1p-22 * std::fabs(corners.upper));
    range = {least(range.lower, weighted), greatest(range.upper, weighted)};
    if (range.lower <= 0.0 && range.upper >= 0.0 && plane.holds_origin()) return 0.0;
    const double t = plane.distance / plane.facing;
    if (!(std::fabs(t) <= std::numeric_limits<double>::max())) return weighted;
    return least(greatest(t, range.lower), range.upper);
  }

  /// A corner as the edge functions see it.
  struct Corner {
    double x, y, z;

    double size() const { return std::fabs(x) + std::fabs(y) + std::fabs(z); }
  };

  /// Whether the plane of such a triangle is certainly met before the ray's range, as that of the triangle
  /// which the ray leaves is: decided without the plane. `z` is s as weighing gives it, times det. What the
  /// corners are off across the ray makes `slope` / det times that along it (docs/accuracy.md).
  static bool is_before_range(const TraversalRay& ray, const Corner& a, const Corner& b, const Corner& c,
                              double z, double det) {
    const Corner e1{b.x - a.x, b.y - a.y, b.z - a.z}, e2{c.x - a.x, c.y - a.y, c.z - a.z};
    const double slope = std::fabs(e1.z * e2.y - e2.z * e1.y) + std::fabs(e1.z * e2.x - e2.z * e1.x);
    const double reach = a.size() + b.size() + c.size();
    const double size = std::fabs(det);
    const double error = 0x1p-20 * reach * (size + slope);
    const double ahead = std::copysign(1.0, det) * (ray.sign_z * z - ray.s_near * det);
    return ahead < -error && size > 0x1p-16 * reach * reach && ray.tnear >= 0.0f;
  }

  /// Decides candidate `i` in double. True, and t, u, v of the hit, if the ray's line meets it (edges
  /// included).
  static bool decide(const TraversalRay& ray, const Ray& query, const LeafHeader& leaf,
                     const MeshRecord& mesh, const Candidates& s, unsigned i, Hit& hit) {
    const auto corner = [&](int k) {
      const std::uint8_t slot = leaf.corners[k][i];
      return Corner{s.x[slot], s.y[slot], s.axis[2][slot]};
    };
    const Corner a = corner(0), b = corner(1), c = corner(2);
    const double wa = c.x * b.y - c.y * b.x;
    const double wb = a.x * c.y - a.y * c.x;
    const double wc = b.x * a.y - b.y * a.x;
    // A product, which neither overflows nor vanishes, for one branch: which sign it is cannot be predicted.
    if (least(least(wa, wb), wc) * greatest(greatest(wa, wb), wc) < 0.0) return false;
    const double det = wa + wb + wc;
    if (det == 0.0) return false;
    const double inverse = 1.0 / det;
    const double za = wa * a.z, zb = wb * b.z, zc = wc * c.z;
    const double z = za + zb + zc;
    double t = z / (det * ray.direction_z);
    const bool cancels = std::fabs(za) + std::fabs(zb) + std::fabs(zc) > 2.0 * std::fabs(z);
    if (cancels) [[unlikely]] {
      if (is_before_range(ray, a, b, c, z, det)) return false;
      const double to_t = 1.0 / ray.direction_z;
      t = t_of_plane(query, leaf, mesh, i, Range::of(a.z * to_t, b.z * to_t, c.z * to_t), t);
    }
    hit.t = static_cast<float>(t);
    if (!is_finite(hit.t)) return false;
    hit.u = static_cast<float>(wb * inverse);
    hit.v = static_cast<float>(wc * inverse);
    return true;
  }

  static Vec3f normal(const TraversalRay& ray, const LeafHeader& leaf, const Candidates& s, unsigned i) {
    const std::uint8_t a = leaf.corners[0][i], b = leaf.corners[1][i], c = leaf.corners[2][i];
    float e1[3], e2[3];
    for (int k = 0; k < 3; ++k) {
      e1[k] = s.axis[k][b] - s.axis[k][a];
      e2[k] = s.axis[k][c] - s.axis[k][a];
    }
    float n[3];  // kx, ky, kz is a rotation of x, y, z
    n[ray.kx] = e1[1] * e2[2] - e1[2] * e2[1];
    n[ray.ky] = e1[2] * e2[0] - e1[0] * e2[2];
    n[ray.kz] = e1[0] * e2[1] - e1[1] * e2[0];
    return {n[0], n[1], n[2]};
  }
};

}  // namespace
}  // namespace stbvh
