// Ray against a leaf of up to eight triangles over up to eight vertices, watertight. Part of the traversal
// sources.
//
// The test of Woop, Benthin and Wald (JCGT 2013), split in two. For all eight triangles at once, in float and
// without fma: a product rounded to float is monotone, so a difference of two products has the right sign or
// is zero, and a triangle whose edge functions have both signs is missed for certain. What is left over is
// decided in double, where the products are exact, and the difference of two keeps its sign: edge functions
// of the two triangles of an edge are exactly opposite. Both see the same vertices: interpolated once for
// each vertex, always alike.

struct WatertightTest {
  static constexpr bool kFindDecides = false;

  /// Candidates of one leaf, in memory for the scalar part.
  struct Candidates {
    alignas(32) float x[kWidth], y[kWidth];  ///< sheared: the ray is at (0, 0)
    alignas(32) float axis[3][kWidth];       ///< relative to the origin, order (kx, ky, kz)
    bool is_certain = false;  ///< one of them is hit within the ray's range, whatever is rounded
  };

  // Boxes -------------------------------------------------------------------------------------------------

  /// How far the triangle test may see a vertex from where it is: its translation, interpolation and shear
  /// round by up to 8 * 2^-24 of the distance of the vertex, the slab distances by 3 more, and a hit may lie
  /// 16 before or behind that vertex (docs/accuracy.md). The second term survives the rounding of the sum
  /// with the origin.
  static Axes slack(Axes origin, Axes distance) {
    const Axes size = _mm_andnot_ps(_mm_set1_ps(-0.0f), origin);
    return _mm_add_ps(_mm_mul_ps(_mm_set1_ps(0x1p-19f), distance), _mm_mul_ps(_mm_set1_ps(0x1p-22f), size));
  }

  /// The near planes move towards the ray's origin by the slack, the far planes away from it.
  static void set_slabs(Axes origin, Axes direction, Axes inverse, Axes distance, TraversalRay& r) {
    const Axes sign = _mm_and_ps(_mm_set1_ps(-0.0f), direction);
    const Axes backwards = _mm_or_ps(sign, slack(origin, distance));
    splat_axes(r.inverse, inverse);
    splat_axes(r.near_origin, _mm_add_ps(origin, backwards));
    splat_axes(r.far_origin, _mm_sub_ps(origin, backwards));
  }

  static F32x8 slab(F32x8 plane, F32x8 origin, F32x8 inverse) { return (plane - origin) * inverse; }

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

  // The distance ------------------------------------------------------------------------------------------

  /// A triangle as it stands to the ray, in double: corners relative to the origin, and their plane. The
  /// floats that these are made of are exact, so what rounds is 2^-53 of the triangle's size, not 2^-24 of
  /// it.
  struct Plane {
    double corners[3][3];  ///< of each corner: x, y, z
    double normal[3];      ///< cross(b - a, c - a)
    double distance;       ///< from the origin, times the normal's length
    double facing;         ///< normal . direction

    Plane(const TraversalRay& ray, const LeafMotion& motion, const std::uint8_t (&slots)[3]) {
      const double f1 = motion.fraction, f0 = 1.0 - f1;
      for (int k = 0; k < 3; ++k) {
        const double o = ray.origin[k];
        const float* const from = motion.begin->position[k];
        const float* const to = motion.end->position[k];
        for (int i = 0; i < 3; ++i) corners[i][k] = f0 * (from[slots[i]] - o) + f1 * (to[slots[i]] - o);
      }
      double e1[3], e2[3];
      for (int k = 0; k < 3; ++k) {
        e1[k] = corners[1][k] - corners[0][k];
        e2[k] = corners[2][k] - corners[0][k];
      }
      normal[0] = e1[1] * e2[2] - e1[2] * e2[1];
      normal[1] = e1[2] * e2[0] - e1[0] * e2[2];
      normal[2] = e1[0] * e2[1] - e1[1] * e2[0];
      distance = normal[0] * corners[0][0] + normal[1] * corners[0][1] + normal[2] * corners[0][2];
      facing = normal[0] * ray.direction[0] + normal[1] * ray.direction[1] + normal[2] * ray.direction[2];
    }

    /// Whether the plane passes the ray's origin as near as floats tell: it meets the point if each of its
    /// coordinates moves by 3 units in the last place.
    bool holds_origin(const TraversalRay& ray) const {
      const double size = std::fabs(normal[0] * ray.origin[0]) + std::fabs(normal[1] * ray.origin[1]) +
                          std::fabs(normal[2] * ray.origin[2]);
      return std::fabs(distance) <= 3 * 0x1p-23 * size;
    }
  };

  static double least(double a, double b) { return a < b ? a : b; }
  static double greatest(double a, double b) { return a > b ? a : b; }

  /// Values of s, the distance along the ray on the axis kz, with its sign.
  struct Range {
    double lower, upper;

    static Range of(double a, double b, double c, double slack) {
      return {least(least(a, b), c) - slack, greatest(greatest(a, b), c) + slack};
    }
  };

  /// Where the plane is met outside the triangle, or at the origin as near as floats tell: the nearest s
  /// at which the ray is within the triangle's own bounds, padded by what the boxes above are padded for.
  /// `weighted` is one of those.
  static double within_bounds(const TraversalRay& ray, const Plane& plane, Range range, double weighted) {
    const auto& q = plane.corners;
    double reach = 0.0;
    for (const auto& corner : q) {
      for (int k = 0; k < 3; ++k) reach = greatest(reach, std::fabs(corner[k]));
    }
    const double slack = 0x1p-21 * reach;
    const int axes[] = {ray.kx, ray.ky};
    for (const int k : axes) {
      const double slope = ray.direction[k] / ray.direction_z;
      if (slope == 0.0) continue;
      const Range across = Range::of(q[0][k], q[1][k], q[2][k], slack);
      range.lower = greatest(range.lower, (slope > 0.0 ? across.lower : across.upper) / slope);
      range.upper = least(range.upper, (slope > 0.0 ? across.upper : across.lower) / slope);
    }
    range.lower = least(range.lower, weighted);
    range.upper = greatest(range.upper, weighted);
    if (plane.holds_origin(ray) && range.lower <= 0.0 && range.upper >= 0.0) return 0.0;
    const double s = plane.distance / plane.facing * ray.direction_z;
    if (!(std::fabs(s) <= std::numeric_limits<double>::max())) return weighted;
    return least(greatest(s, range.lower), range.upper);
  }

  /// Decides candidate `i` in double. True, and t, u, v, normal of the hit, if the ray's line meets it (edges
  /// included).
  static bool decide(const TraversalRay& ray, const LeafHeader& leaf, const LeafMotion& motion,
                     const Candidates& s, unsigned i, Hit& hit) {
    const std::uint8_t slots[3] = {leaf.corners[0][i], leaf.corners[1][i], leaf.corners[2][i]};
    const auto [a, b, c] = slots;
    const double ax = s.x[a], ay = s.y[a], bx = s.x[b], by = s.y[b], cx = s.x[c], cy = s.y[c];
    const double wa = cx * by - cy * bx;
    const double wb = ax * cy - ay * cx;
    const double wc = bx * ay - by * ax;
    if ((wa < 0.0 || wb < 0.0 || wc < 0.0) && (wa > 0.0 || wb > 0.0 || wc > 0.0)) return false;
    const double det = wa + wb + wc;
    if (det == 0.0) return false;
    const double inverse = 1.0 / det;
    const double az = s.axis[2][a], bz = s.axis[2][b], cz = s.axis[2][c];
    const double weighted = (wa * az + wb * bz + wc * cz) * inverse;
    Range range = Range::of(az, bz, cz, 0.0);
    range.lower -= 0x1p-22 * std::fabs(range.lower);
    range.upper += 0x1p-22 * std::fabs(range.upper);
    // Most candidates that are not the hit lie behind one.
    const double nearest = ray.direction_z > 0.0 ? range.lower : -range.upper;
    if (nearest > ray.s_far) return false;
    const Plane plane(ray, motion, slots);
    double t = plane.distance / plane.facing;
    const double along = t * ray.direction_z;
    const bool is_clear = std::fabs(along - weighted) <= 0x1p-20 * std::fabs(weighted) &&
                          along >= range.lower && along <= range.upper && !plane.holds_origin(ray);
    if (!is_clear) t = within_bounds(ray, plane, range, weighted) / ray.direction_z;
    hit.t = static_cast<float>(t);
    if (!is_finite(hit.t)) return false;
    hit.u = static_cast<float>(wb * inverse);
    hit.v = static_cast<float>(wc * inverse);
    hit.normal = {static_cast<float>(plane.normal[0]), static_cast<float>(plane.normal[1]),
                  static_cast<float>(plane.normal[2])};
    return true;
  }
};
