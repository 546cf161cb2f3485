/// The nodes of `slabs-12`, and their test (slabs_12.cpp).
#pragma once

#include <limits>

#include "harness/structures/gallery/centred_ray.inl"
#include "harness/structures/gallery/gallery_view.h"
#include "traverse/steps.inl"

namespace stbvh::harness::gallery {

constexpr int kSlabAxes = 3;
constexpr int kSlabDirections = 7;  ///< in space: the axes, then the diagonals of the cube
constexpr int kSpaceSlabs = 11;     ///< all but that of time: three along axes, two along each diagonal

/// Sums of a point's coordinates with these factors.
constexpr float kSlabDirection[kSlabDirections][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1}, {1, 1, 1},
                                                      {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};
/// Slabs 3, 5, 7, 9 move against the direction of their diagonal, 4, 6, 8, 10 with it.
constexpr int direction_of_slab(int slab) {
  return slab < kSlabAxes ? slab : kSlabAxes + (slab - kSlabAxes) / 2;
}
constexpr int time_sign_of_slab(int slab) {
  return slab < kSlabAxes ? 0 : (slab - kSlabAxes) % 2 == 0 ? 1 : -1;
}

/// Each child is alive for time_begin <= t <= time_last, and then lies where
/// planes[slab][0] <= n . (p - centre) + sign * scale * t <= planes[slab][1].
struct alignas(kUnitBytes) Slabs12Node {
  float planes[kSpaceSlabs][2][kWidth];
  float time_begin[kWidth];
  float time_last[kWidth];
  Link children[kWidth];
};
static_assert(sizeof(Slabs12Node) == 768 + 32);

/// What all nodes share: GalleryView::method.
struct Slabs12Scene {
  float centre[3];
  float scale;  ///< of time against space: a speed
};

namespace {

/// All that a node's test needs of a ray is known before: its place and its speed along the normal of each
/// slab.
///
/// With D the distance of CentredRay, u = 2^-24, T = scale * t, and L the sum of the magnitudes of n's
/// factors, 1 or 3,
/// - the point that the triangle test accepts lies within 8u D of the ray's along the axes
///   (docs/accuracy.md): 8u L D along n;
/// - n . (o - centre) + T is off by u L D for the difference, 2u L D for the sums of a diagonal, u |T| for
/// the
///   product, and u (L D + |T|) for the last sum;
/// - n . d is off by 3u L, and is multiplied by |s| <= D: 3u L D. So its sign may be wrong, too;
/// - difference with the plane, inverse and product: 3u of |s n . d| <= L D;
/// - the sum with the padding: u (L D + |T|).
/// Together 19u L D + 3u |T|, first order; the padding is 24u L D + 4u |T|. Its last term holds where
/// denormal numbers are rounded, or flushed to zero.
class Slabs12 {
 public:
  Slabs12(const GalleryView& view, const TraversalRay& traversed) {
    const auto& scene = *static_cast<const Slabs12Scene*>(view.method);
    const CentredRay ray(view, traversed, scene.centre);
    const float time = scene.scale * traversed.time;
    float place[kSlabDirections], padding[kSlabDirections];
    for (int i = 0; i < kSlabDirections; ++i) {
      place[i] = along(kSlabDirection[i], ray.origin);
      const float speed = along(kSlabDirection[i], ray.direction);
      inverse_[i] = std::copysign(1.0f / std::max(std::fabs(speed), kLeastDirection), speed);
      near_[i] = std::signbit(speed) ? 1 : 0;
      const float size = i < kSlabAxes ? 1.0f : 3.0f;
      padding[i] = std::copysign(size * 0x1.8p-20f * ray.distance + 0x1p-22f * std::fabs(time) +
                                     64.0f * std::numeric_limits<float>::min(),
                                 speed);
    }
    for (int slab = 0; slab < kSpaceSlabs; ++slab) {
      const int i = direction_of_slab(slab);
      const float at = place[i] + static_cast<float>(time_sign_of_slab(slab)) * time;
      near_origin_[slab] = at + padding[i];
      far_origin_[slab] = at - padding[i];
    }
  }

  ChildHits intersect(const TraversalRay& ray, const Slabs12Node& node) const {
    F32x8 entry = splat(ray.s_near);
    F32x8 exit = splat(ray.s_far);
#pragma GCC unroll 11
    for (int slab = 0; slab < kSpaceSlabs; ++slab) {
      const int i = direction_of_slab(slab);
      const F32x8 inverse = splat(inverse_[i]);
      const auto met = [&](int side, float origin) {
        return (load(node.planes[slab][side]) - splat(origin)) * inverse;
      };
      entry = max(entry, met(near_[i], near_origin_[slab]));
      exit = min(exit, met(1 - near_[i], far_origin_[slab]));
    }
    const F32x8 time = splat(ray.time);
    const unsigned alive =
        less_equal(load(node.time_begin), time).bits & less_equal(time, load(node.time_last)).bits;
    return {entry, less_equal(entry, exit).bits & alive};
  }

 private:
  static float along(const float (&n)[3], const float (&v)[3]) {
    return n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
  }

  float near_origin_[kSpaceSlabs], far_origin_[kSpaceSlabs];
  float inverse_[kSlabDirections];
  int near_[kSlabDirections];  ///< which side of a slab
};

template <typename Test>
inline ChildHits intersect_any_node(const TraversalRay& ray, const Slabs12& slabs, LinkKind,
                                    const std::byte* data, const Link*& children) {
  const auto& node = *reinterpret_cast<const Slabs12Node*>(data);
  children = node.children;
  return slabs.intersect(ray, node);
}

}  // namespace
}  // namespace stbvh::harness::gallery
