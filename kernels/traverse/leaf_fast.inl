/// Ray against a leaf as renderers commonly do it: Moeller and Trumbore (1997), in float, eight triangles at
/// once. What it costs and saves: `stbvh-ab pareto`.
#pragma once

#include "traverse/leaf_vertices.inl"
#include "traverse/slabs.inl"

namespace stbvh {
namespace {

struct FastTest : UnpaddedSlabs {
  static constexpr bool kFindDecides = true;  ///< find() returns hits, not candidates

  struct Candidates {
    alignas(32) float t[kWidth], u[kWidth], v[kWidth];
    alignas(32) float normal[3][kWidth];
    bool is_certain = false;  ///< there is one: each is a hit
  };

  static LeafVertices interpolated(const TraversalRay& ray, const StepVertices& v0, const StepVertices& v1,
                                   float f) {
    const F32x8 f0 = splat(1.0f - f);
    const F32x8 f1 = splat(f);
    const auto axis = [&](int k) {
      return multiply_add(f1, load(v1.position[k]), f0 * load(v0.position[k])) - splat(ray.origin[k]);
    };
    return {axis(0), axis(1), axis(2)};
  }

  static LeafVertices at_rest(const TraversalRay& ray, const StepVertices& v) {
    const auto axis = [&](int k) { return load(v.position[k]) - splat(ray.origin[k]); };
    return {axis(0), axis(1), axis(2)};
  }

  struct Vectors {
    F32x8 x, y, z;
  };
  static Vectors corner(const LeafVertices& p, const std::uint8_t* slots) {
    const Slots8 s = load_slots(slots);
    return {permute(p.x, s), permute(p.y, s), permute(p.z, s)};
  }
  static Vectors difference(const Vectors& a, const Vectors& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  static Vectors cross(const Vectors& a, const Vectors& b) {
    return {multiply_subtract(a.y, b.z, a.z * b.y), multiply_subtract(a.z, b.x, a.x * b.z),
            multiply_subtract(a.x, b.y, a.y * b.x)};
  }
  static F32x8 dot(const Vectors& a, const Vectors& b) {
    return multiply_add(a.x, b.x, multiply_add(a.y, b.y, a.z * b.z));
  }

  /// Bits of the triangles that are hit in the ray's range; `c` is filled if there are any. With kAnyHit only
  /// whether there are.
  template <bool kAnyHit>
  static unsigned find(const TraversalRay& ray, const LeafHeader& leaf, const LeafVertices& p,
                       Candidates& c) {
    const Vectors a = corner(p, leaf.corners[0]);
    const Vectors e1 = difference(corner(p, leaf.corners[1]), a);
    const Vectors e2 = difference(corner(p, leaf.corners[2]), a);
    const Vectors d{splat(ray.direction[0]), splat(ray.direction[1]), splat(ray.direction[2])};
    const Vectors normal = cross(e1, e2);
    const Vectors moment = cross(a, d);
    const F32x8 det = dot(normal, d);
    const F32x8 size = flip_sign(det, det);
    const F32x8 u = flip_sign(dot(moment, e2), det);
    const F32x8 v = splat(0.0f) - flip_sign(dot(moment, e1), det);
    const F32x8 t = flip_sign(dot(normal, a), det);
    const F32x8 zero = splat(0.0f);
    const unsigned bits = less_equal(zero, u).bits & less_equal(zero, v).bits & less_equal(u + v, size).bits &
                          less(size * splat(ray.tnear), t).bits & less_equal(t, size * splat(ray.tfar)).bits &
                          ((1u << leaf.triangle_count) - 1);
    c.is_certain = bits != 0;
    if (kAnyHit || bits == 0) return 0;
    const F32x8 inverse = splat(1.0f) / size;
    store(c.t, t * inverse);
    store(c.u, u * inverse);
    store(c.v, v * inverse);
    store(c.normal[0], normal.x);
    store(c.normal[1], normal.y);
    store(c.normal[2], normal.z);
    return bits;
  }

  static bool decide(const TraversalRay&, const Ray&, const LeafHeader&, const MeshRecord&,
                     const Candidates& c, unsigned i, Hit& hit) {
    hit.t = c.t[i];
    hit.u = c.u[i];
    hit.v = c.v[i];
    return is_finite(hit.t);
  }

  static Vec3f normal(const TraversalRay&, const LeafHeader&, const Candidates& c, unsigned i) {
    return {c.normal[0][i], c.normal[1][i], c.normal[2][i]};
  }
};

}  // namespace
}  // namespace stbvh
