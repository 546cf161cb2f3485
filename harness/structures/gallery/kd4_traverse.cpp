/// Havran's recursive traversal of a kd-tree with a stack, on the interval of the ray that lies in each cell,
/// with the kernels' padding.
///
/// No cell hides what the triangle test accepts: the ray's point at a hit, as it is reported, is within the
/// slack of the triangle's bounds in each coordinate (docs/accuracy.md). Let q be the point of those bounds
/// next to it. All boxes of the reference hold q, at each node one of the children that q may be counted to
/// holds the reference, and the slab test with q's side of the plane accepts the hit's distance, as it does
/// with the plane of a box: planes lie within the scene's bounds, so that the slack covers them.
#include "simd/f32x8_scalar.h"  // before the traversal, which is then made of it

#include "harness/structures/gallery/kd4_nodes.h"
#include "traverse/steps.inl"

namespace stbvh::harness::gallery {
namespace {

/// The meshlets that a ray was tested against last. One that others have driven out is tested again, which
/// changes nothing.
class Mailbox {
 public:
  Mailbox() { std::fill_n(links_, kSlots, kNoLeaf); }

  /// False: it was tested.
  bool enter(Link link) {
    Link& slot = links_[link * 0x9E3779B1u >> (32 - kBits)];
    if (slot == link) return false;
    slot = link;
    return true;
  }

 private:
  static constexpr unsigned kBits = 6;
  static constexpr std::size_t kSlots = 1u << kBits;
  static constexpr Link kNoLeaf = 0xFFFFFFFFu;  // a leaf does not fit there
  Link links_[kSlots];
};

/// A node, and where the ray is in its cell.
struct Part {
  std::uint32_t node;
  float enter, exit;
};

/// The ray's part in the root's cell.
Part root_part(const KdView& view, const TraversalRay& ray) {
  Part part{0, ray.s_near, ray.s_far};
  for (int i = 0; i < 3; ++i) {
    const bool reversed = ray.inverse[i] < 0.0f;
    const float near = reversed ? view.upper[i] : view.lower[i];
    const float far = reversed ? view.lower[i] : view.upper[i];
    part.enter = std::max(part.enter, (near - ray.near_origin[i]) * ray.inverse[i]);
    part.exit = std::min(part.exit, (far - ray.far_origin[i]) * ray.inverse[i]);
  }
  return part;
}

/// True: any hit is found.
template <bool kAnyHit, bool kCounted>
bool test_cell(const KdView& view, const KdNode& cell, const Query& query, TraversalRay& ray,
               Mailbox& mailbox, bool& found) {
  for (const Link *link = view.links + cell.first(), *end = link + cell.count(); link != end; ++link) {
    if (!mailbox.enter(*link)) continue;
    const auto& leaf = *reinterpret_cast<const LeafHeader*>(address(view, *link));
    if (test_leaf<WatertightTest, kAnyHit, false, kCounted>(view, ray, leaf, query, found)) return true;
  }
  return false;
}

template <bool kAnyHit, bool kCounted>
bool trace_kd(const KdView& view, const Query& query) {
  TraversalRay ray;
  if (view.empty || !setup_ray<WatertightTest>(view, query.ray, ray)) return false;
  Part part = root_part(view, ray);
  if (!(part.enter <= part.exit)) return false;
  Part stack[kMostKdLevels];
  Part* top = stack;
  Mailbox mailbox;
  bool found = false;
  for (;;) {
    const KdNode& node = view.nodes[part.node];
    if (kCounted) ++query.counters->nodes;
    if (node.axis() == KdAxis::kTime) {
      part.node = node.first() + (ray.time >= node.position());
      continue;
    }
    if (node.axis() != KdAxis::kCell) {
      const auto axis = static_cast<unsigned>(node.axis());
      const bool reversed = ray.inverse[axis] < 0.0f;
      // Beyond the plane from `enter` on, and before it up to `exit`: both for a while.
      const float enter = (node.position() - ray.near_origin[axis]) * ray.inverse[axis];
      const float exit = (node.position() - ray.far_origin[axis]) * ray.inverse[axis];
      const Part beyond{node.first() + !reversed, std::max(part.enter, enter), part.exit};
      if (part.enter > exit) {
        part = beyond;
        continue;
      }
      if (beyond.enter <= beyond.exit) *top++ = beyond;
      part = {node.first() + reversed, part.enter, std::min(part.exit, exit)};
      continue;
    }
    if (test_cell<kAnyHit, kCounted>(view, node, query, ray, mailbox, found)) return true;
    do {
      if (top == stack) return found;
      part = *--top;
    } while (part.enter > ray.s_far);  // a hit in this cell would be farther than the one there is
  }
}

}  // namespace

bool intersect_kd(const KdView& view, const Ray& ray, Hit& hit) {
  return trace_kd<false, false>(view, {ray, &hit, nullptr, nullptr});
}
bool intersect_kd_counted(const KdView& view, const Ray& ray, Hit& hit, TraversalCounters& counters) {
  return trace_kd<false, true>(view, {ray, &hit, nullptr, &counters});
}
bool occluded_kd(const KdView& view, const Ray& ray) {
  return trace_kd<true, false>(view, {ray, nullptr, nullptr, nullptr});
}

}  // namespace stbvh::harness::gallery
