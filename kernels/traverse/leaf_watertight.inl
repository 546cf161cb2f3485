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
  /// round by up to 8 * 2^-24 of the distance of the vertex, the slab distances by 3 more (docs/accuracy.md).
  /// The second term survives the rounding of the sum with the origin.
  static Axes slack(Axes origin, Axes distance) {
    const Axes size = _mm_andnot_ps(_mm_set1_ps(-0.0f), origin);
    return _mm_add_ps(_mm_mul_ps(_mm_set1_ps(0x1p-20f), distance), _mm_mul_ps(_mm_set1_ps(0x1p-22f), size));
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

  /// Decides candidate `i` in double. True, and t, u, v of the hit, if the ray's line meets it (edges
  /// included).
  static bool decide(const TraversalRay& ray, const LeafHeader& leaf, const Candidates& s, unsigned i,
                     Hit& hit) {
    const std::uint8_t a = leaf.corners[0][i], b = leaf.corners[1][i], c = leaf.corners[2][i];
    const double ax = s.x[a], ay = s.y[a], bx = s.x[b], by = s.y[b], cx = s.x[c], cy = s.y[c];
    const double wa = cx * by - cy * bx;
    const double wb = ax * cy - ay * cx;
    const double wc = bx * ay - by * ax;
    if ((wa < 0.0 || wb < 0.0 || wc < 0.0) && (wa > 0.0 || wb > 0.0 || wc > 0.0)) return false;
    const double det = wa + wb + wc;
    if (det == 0.0) return false;
    const double inverse = 1.0 / det;
    const double z = wa * s.axis[2][a] + wb * s.axis[2][b] + wc * s.axis[2][c];
    hit.t = static_cast<float>(z / (det * ray.direction_z));
    if (!is_finite(hit.t)) return false;
    hit.u = static_cast<float>(wb * inverse);
    hit.v = static_cast<float>(wc * inverse);
    return true;
  }

  static Vec3f normal(const TraversalRay& ray, const LeafHeader& leaf, const Candidates& s, unsigned i) {
    const std::uint8_t a = leaf.corners[0][i], b = leaf.corners[1][i], c = leaf.corners[2][i];
    float e1[3], e2[3];
    const int order[3] = {ray.kx, ray.ky, ray.kz};
    for (int k = 0; k < 3; ++k) {
      e1[order[k]] = s.axis[k][b] - s.axis[k][a];
      e2[order[k]] = s.axis[k][c] - s.axis[k][a];
    }
    return {e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]};
  }
};
