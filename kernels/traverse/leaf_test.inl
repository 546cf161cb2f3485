// Ray against a leaf of up to eight triangles over up to eight vertices. Part of the traversal sources.
//
// The watertight test of Woop, Benthin and Wald (JCGT 2013), split in two. For all eight triangles at once,
// in float and without fma: a product rounded to float is monotone, so a difference of two products has the
// right sign or is zero, and a triangle whose edge functions have both signs is missed for certain. What is
// left over is decided in double, where the products are exact, and the difference of two keeps its sign:
// edge functions of the two triangles of an edge are exactly opposite. Both see the same vertices:
// interpolated once for each vertex, always alike.

/// Vertices of a leaf relative to the ray's origin at the ray's time, axes in the order (kx, ky, kz).
struct LeafVertices {
  F32x8 x, y, z;
};

inline F32x8 relative(const float* position, F32x8 origin) {
  return load(position) - origin;
}

/// (1 - f) * p_k + f * p_{k+1}; the origin is taken off first, before anything could cancel.
inline F32x8 interpolate(const float* p0, const float* p1, F32x8 origin, F32x8 f0, F32x8 f1) {
  return f0 * relative(p0, origin) + f1 * relative(p1, origin);
}

inline LeafVertices leaf_vertices(const TraversalRay& ray, const StepVertices& v0, const StepVertices& v1,
                                  float f) {
  const F32x8 f0 = splat(1.0f - f);
  const F32x8 f1 = splat(f);
  const auto axis = [&](int k) {
    return interpolate(v0.position[k], v1.position[k], splat(ray.origin[k]), f0, f1);
  };
  return {axis(ray.kx), axis(ray.ky), axis(ray.kz)};
}

inline LeafVertices leaf_vertices(const TraversalRay& ray, const StepVertices& v) {
  const auto axis = [&](int k) { return relative(v.position[k], splat(ray.origin[k])); };
  return {axis(ray.kx), axis(ray.ky), axis(ray.kz)};
}

/// Reads the vertices of an indexed leaf at one step from the caller's buffer.
inline void gather_step(const VertexBufferView& buffer, const std::uint32_t* vertices, StepVertices& out) {
  const char* data = static_cast<const char*>(buffer.data);
  for (std::size_t slot = 0; slot < kWidth; ++slot) {
    float p[3];
    std::memcpy(p, data + vertices[slot] * buffer.stride, sizeof p);
    out.position[0][slot] = p[0];
    out.position[1][slot] = p[1];
    out.position[2][slot] = p[2];
  }
}

inline LeafVertices load_leaf(const TraversalRay& ray, const LeafHeader& leaf, const MeshRecord& mesh) {
  const bool is_static = mesh.grid.segments == 0.0f;
  const SegmentTime at = is_static ? SegmentTime{0, 0.0f} : segment_at(mesh.grid, ray.time);
  if (leaf.indexed) {
    const auto* vertices = reinterpret_cast<const std::uint32_t*>(&leaf + 1);
    alignas(32) StepVertices steps[2];
    gather_step(mesh.steps[at.segment], vertices, steps[0]);
    if (is_static) return leaf_vertices(ray, steps[0]);
    gather_step(mesh.steps[at.segment + 1], vertices, steps[1]);
    return leaf_vertices(ray, steps[0], steps[1], at.fraction);
  }
  const auto* steps = reinterpret_cast<const StepVertices*>(&leaf + 1);
  if (is_static) return leaf_vertices(ray, steps[0]);
  const StepVertices* step = steps + (at.segment - leaf.first_segment);
  return leaf_vertices(ray, step[0], step[1], at.fraction);
}

/// Candidates of one leaf, in memory for the scalar part.
struct ShearedVertices {
  alignas(32) float x[kWidth], y[kWidth];  ///< sheared: the ray is at (0, 0)
  alignas(32) float axis[3][kWidth];       ///< relative to the origin, order (kx, ky, kz)
};

/// Decides triangle `i` in double. True, and t, u, v of the hit, if the ray's line meets it (edges included).
inline bool decide(const TraversalRay& ray, const LeafHeader& leaf, const ShearedVertices& s, unsigned i,
                   float& t, float& u, float& v) {
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
  t = static_cast<float>(z / (det * ray.direction_z));
  if (!is_finite(t)) return false;
  u = static_cast<float>(wb * inverse);
  v = static_cast<float>(wc * inverse);
  return true;
}

inline Vec3f triangle_normal(const TraversalRay& ray, const LeafHeader& leaf, const ShearedVertices& s,
                             unsigned i) {
  const std::uint8_t a = leaf.corners[0][i], b = leaf.corners[1][i], c = leaf.corners[2][i];
  float e1[3], e2[3];
  const int order[3] = {ray.kx, ray.ky, ray.kz};
  for (int k = 0; k < 3; ++k) {
    e1[order[k]] = s.axis[k][b] - s.axis[k][a];
    e2[order[k]] = s.axis[k][c] - s.axis[k][a];
  }
  return {e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]};
}

/// Bits of the triangles that may be hit; `s` is filled if there are any. With kAnyHit, also whether one of
/// them is hit for certain: its edge functions have one sign, none is zero, and all its vertices are so far
/// along the ray that the hit is in the ray's range, whatever is rounded.
template <bool kAnyHit>
inline unsigned candidates(const TraversalRay& ray, const LeafHeader& leaf, const LeafVertices& p,
                           ShearedVertices& s, bool& certain) {
  const F32x8 x = p.x - splat(ray.shear_x) * p.z;
  const F32x8 y = p.y - splat(ray.shear_y) * p.z;
  const Slots8 a = load_slots(leaf.corners[0]);
  const Slots8 b = load_slots(leaf.corners[1]);
  const Slots8 c = load_slots(leaf.corners[2]);
  const F32x8 ax = permute(x, a), ay = permute(y, a);
  const F32x8 bx = permute(x, b), by = permute(y, b);
  const F32x8 cx = permute(x, c), cy = permute(y, c);
  const F32x8 wa = cx * by - cy * bx;
  const F32x8 wb = ax * cy - ay * cx;
  const F32x8 wc = bx * ay - by * ax;
  const F32x8 lowest = min(min(wa, wb), wc);
  const F32x8 highest = max(max(wa, wb), wc);
  const unsigned triangles = (1u << leaf.triangle_count) - 1;
  const unsigned bits = ~straddles_zero(lowest, highest).bits & triangles;
  if (bits != 0) {
    if (kAnyHit) {
      const F32x8 distance = p.z * splat(ray.sign_z);
      const F32x8 da = permute(distance, a), db = permute(distance, b), dc = permute(distance, c);
      const unsigned inside = less(splat(ray.certain_near), min(min(da, db), dc)).bits &
                              less(max(max(da, db), dc), splat(ray.certain_far)).bits;
      const F32x8 zero = splat(0.0f);
      certain = ((less(zero, lowest).bits | less(highest, zero).bits) & inside & bits) != 0;
      if (certain) return bits;
    }
    store(s.x, x);
    store(s.y, y);
    store(s.axis[0], p.x);
    store(s.axis[1], p.y);
    store(s.axis[2], p.z);
  }
  return bits;
}
