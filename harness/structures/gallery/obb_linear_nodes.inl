/// The nodes of `obb-linear`, and their test (obb_linear.cpp).
#pragma once

#include <limits>

#include "harness/structures/gallery/centred_ray.inl"
#include "harness/structures/gallery/gallery_view.h"
#include "traverse/steps.inl"

namespace stbvh::harness::gallery {

/// Each child lies in a box of its own frame: planes + (t - begin) * slopes <= M (p - centre) for the lower
/// faces, >= for the upper ones, with the child's matrix M as its floats say.
struct alignas(kUnitBytes) ObbNode {
  float frames[3][3][kWidth];  ///< rows and columns of M
  float planes[kPlanes][kWidth];
  float slopes[kPlanes][kWidth];
  Link children[kWidth];
};
static_assert(sizeof(ObbNode) == 8 * (9 + 12 + 1) * 4);

/// What all nodes share: GalleryView::method.
struct ObbScene {
  float centre[3];
};

namespace {

/// A ray is turned into the frame of each child at each node; the padding is the ray's.
///
/// With D the distance of CentredRay and u = 2^-24: the magnitudes of a row of M sum up to sqrt(3), but for
/// its rounding, so that axis by axis in a frame
/// - the point that the triangle test accepts lies within 8u D of the ray's along the world's axes
///   (docs/accuracy.md), thus within sqrt(3) * 8u D = 13.9u D;
/// - M (o - centre) is off by u D for the difference and 3u D for products and sums, with or without fma,
/// each
///   times sqrt(3): 7u D;
/// - M d is off by as many u, and is multiplied by |s| <= D: 7u D. So its sign may be wrong, too;
/// - difference with the plane, inverse and product: 3u of |s M d| <= sqrt(3) D, thus 5.2u D;
/// - the sum of origin and padding: 1.8u D.
/// Together less than 35u D; the padding is 40u D. Its second term holds where denormal numbers are rounded,
/// or flushed to zero.
class ObbSlabs {
 public:
  ObbSlabs(const GalleryView& view, const TraversalRay& ray)
      : ObbSlabs(CentredRay(view, ray, static_cast<const ObbScene*>(view.method)->centre)) {
    elapsed_ = splat(ray.time - view.time_begin);
  }

  ChildHits intersect(const TraversalRay& ray, const ObbNode& node) const {
    F32x8 entry = splat(ray.s_near);
    F32x8 exit = splat(ray.s_far);
    for (int i = 0; i < 3; ++i) {
      const F32x8 origin = turned(node.frames[i], origin_);
      const F32x8 direction = turned(node.frames[i], direction_);
      const F32x8 size = max(flip_sign(direction, direction), splat(kLeastDirection));
      const F32x8 inverse = flip_sign(splat(1.0f) / size, direction);
      const F32x8 lower = face(node, kLowerX + i);
      const F32x8 upper = face(node, kUpperX + i);
      // Near and far by the sign, not by which is met first: so an empty slot is met by no ray.
      const F32x8 near = select_by_sign(direction, lower, upper);
      const F32x8 far = select_by_sign(direction, upper, lower);
      const F32x8 padding = flip_sign(padding_, direction);
      entry = max(entry, (near - (origin + padding)) * inverse);
      exit = min(exit, (far - (origin - padding)) * inverse);
    }
    return {entry, less_equal(entry, exit).bits};
  }

 private:
  explicit ObbSlabs(const CentredRay& ray) {
    for (int i = 0; i < 3; ++i) {
      origin_[i] = splat(ray.origin[i]);
      direction_[i] = splat(ray.direction[i]);
    }
    padding_ = splat(0x1.4p-19f * ray.distance + 64.0f * std::numeric_limits<float>::min());
  }

  static F32x8 turned(const float (&row)[3][kWidth], const F32x8 (&v)[3]) {
    return multiply_add(load(row[2]), v[2], multiply_add(load(row[1]), v[1], load(row[0]) * v[0]));
  }
  F32x8 face(const ObbNode& node, int plane) const {
    return multiply_add(elapsed_, load(node.slopes[plane]), load(node.planes[plane]));
  }

  F32x8 origin_[3], direction_[3];
  F32x8 padding_;
  F32x8 elapsed_;
};

template <typename Test>
inline ChildHits intersect_any_node(const TraversalRay& ray, const ObbSlabs& slabs, LinkKind,
                                    const std::byte* data, const Link*& children) {
  const auto& node = *reinterpret_cast<const ObbNode*>(data);
  children = node.children;
  return slabs.intersect(ray, node);
}

}  // namespace
}  // namespace stbvh::harness::gallery
