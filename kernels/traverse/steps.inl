/// The steps of the traversal: a node's children, a leaf's triangles, and where to go from there. `Test` is
/// how rays are tested against boxes and triangles: WatertightTest or FastTest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "traverse/kernel_table.h"
#include "traverse/leaf_fast.inl"
#include "traverse/leaf_watertight.inl"

namespace stbvh {
namespace {

/// A child that the closest hit may lie in.
struct StackEntry {
  Link link;
  float s;  ///< where the ray enters the box
};

/// The children of one node that any-hit traversal has not looked at yet: bits of `children`, at least one.
struct Siblings {
  const Link* children;
  unsigned bits;
};

struct Query {
  const Ray& ray;
  Hit* hit;                     ///< null: any hit
  const HitFilter* filter;      ///< null: none
  TraversalCounters* counters;  ///< null: none
};

/// Entry distances of the children that the ray meets, and which those are.
struct ChildHits {
  F32x8 entry;
  unsigned bits;
};

/// What the slabs take of a ray, in all lanes: a ray alone keeps it so.
class KeptSlabs {
 public:
  explicit KeptSlabs(const TraversalRay& ray) {
    for (int i = 0; i < 3; ++i) {
      near_origin_[i] = splat(ray.near_origin[i]);
      far_origin_[i] = splat(ray.far_origin[i]);
      inverse_[i] = splat(ray.inverse[i]);
    }
  }
  F32x8 near_origin(int i) const { return near_origin_[i]; }
  F32x8 far_origin(int i) const { return far_origin_[i]; }
  F32x8 inverse(int i) const { return inverse_[i]; }

 private:
  F32x8 near_origin_[3], far_origin_[3], inverse_[3];
};

/// The same, made where it is taken: for rays in flight, which have no registers of their own, a tenth faster
/// than all lanes in memory (docs/performance.md).
class BroadcastSlabs {
 public:
  explicit BroadcastSlabs(const TraversalRay& ray) : ray_(ray) {}
  F32x8 near_origin(int i) const { return splat(ray_.near_origin[i]); }
  F32x8 far_origin(int i) const { return splat(ray_.far_origin[i]); }
  F32x8 inverse(int i) const { return splat(ray_.inverse[i]); }

 private:
  const TraversalRay& ray_;
};

template <typename Test, typename Slabs, typename PlaneAt>
inline ChildHits intersect_children(const TraversalRay& ray, const Slabs& slabs, const PlaneAt& plane_at) {
  const auto near_at = [&](int i) {
    return Test::slab(plane_at(ray.planes->near[i]), slabs.near_origin(i), slabs.inverse(i));
  };
  const auto far_at = [&](int i) {
    return Test::slab(plane_at(ray.planes->far[i]), slabs.far_origin(i), slabs.inverse(i));
  };
  const F32x8 entry = max(max(near_at(0), near_at(1)), max(near_at(2), splat(ray.s_near)));
  const F32x8 exit = min(min(far_at(0), far_at(1)), min(far_at(2), splat(ray.s_far)));
  return {entry, less_equal(entry, exit).bits};
}

inline const float* plane(const void* node, std::uint32_t offset) {
  return reinterpret_cast<const float*>(static_cast<const std::byte*>(node) + offset);
}

/// A plane at the time that lies `elapsed` behind the start of its time range.
inline F32x8 moving_plane(const void* node, std::uint32_t offset, F32x8 elapsed) {
  const float* begin = plane(node, offset);
  const float* slope = plane(node, offset) + offsetof(LinearNode, slopes) / sizeof(float);
  return multiply_add(elapsed, load(slope), load(begin));
}

template <typename Test, typename Slabs>
inline ChildHits intersect_node(const TraversalRay& ray, const Slabs& slabs, const StaticNode& node) {
  return intersect_children<Test>(ray, slabs,
                                  [&](std::uint32_t offset) { return load(plane(&node, offset)); });
}

template <typename Test, typename Slabs>
inline ChildHits intersect_node(const TraversalRay& ray, const Slabs& slabs, const LinearNode& node) {
  const F32x8 elapsed = splat(ray.time - node.time_begin);
  return intersect_children<Test>(ray, slabs,
                                  [&](std::uint32_t offset) { return moving_plane(&node, offset, elapsed); });
}

template <typename Test, typename Slabs>
inline ChildHits intersect_node(const TraversalRay& ray, const Slabs& slabs,
                                const SpatialTemporalNode& node) {
  const F32x8 time = splat(ray.time);
  const F32x8 begin = load(node.time_begin);
  const F32x8 elapsed = time - begin;
  ChildHits hits = intersect_children<Test>(
      ray, slabs, [&](std::uint32_t offset) { return moving_plane(&node, offset, elapsed); });
  hits.bits &= less_equal(begin, time).bits & less_equal(time, load(node.time_last)).bits;
  return hits;
}

template <typename Test, typename Slabs>
inline ChildHits intersect_any_node(const TraversalRay& ray, const Slabs& slabs, LinkKind kind,
                                    const std::byte* data, const Link*& children) {
  if (kind == LinkKind::kLinearNode) {
    const auto& node = *reinterpret_cast<const LinearNode*>(data);
    children = node.children;
    return intersect_node<Test>(ray, slabs, node);
  }
  if (kind == LinkKind::kStaticNode) {
    const auto& node = *reinterpret_cast<const StaticNode*>(data);
    children = node.children;
    return intersect_node<Test>(ray, slabs, node);
  }
  const auto& node = *reinterpret_cast<const SpatialTemporalNode*>(data);
  children = node.children;
  return intersect_node<Test>(ray, slabs, node);
}

/// Tests a leaf. True: traversal may end (any hit found).
template <typename Test, bool kAnyHit, bool kFiltered, bool kCounted>
inline bool test_leaf(const StructureView& structure, TraversalRay& ray, const LeafHeader& leaf,
                      const Query& query, bool& found) {
  const MeshRecord& mesh = structure.meshes[leaf.mesh];
  if ((mesh.mask & ray.mask) == 0 || !(ray.time >= mesh.grid.begin && ray.time <= mesh.grid.end))
    return false;
  if (kCounted) {
    ++query.counters->leaves;
    query.counters->triangle_tests += leaf.triangle_count;
  }
  constexpr bool kAnyWillDo = kAnyHit && !kFiltered;
  typename Test::Candidates c;
  const LeafVertices vertices = load_leaf<Test>(ray, leaf, mesh);
  unsigned bits = Test::template find<kAnyWillDo>(ray, leaf, vertices, c);
  if (kAnyWillDo && c.is_certain) return found = true;
  if constexpr (kAnyWillDo && Test::kFindDecides) return false;
  for (; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<unsigned>(__builtin_ctz(bits));
    Hit hit;
    if (!Test::decide(ray, query.ray, leaf, mesh, c, i, hit)) continue;
    if (!(hit.t > ray.tnear && hit.t <= ray.tfar)) continue;
    if (kAnyWillDo) return found = true;
    hit.normal = Test::normal(ray, leaf, c, i);
    hit.prim_id = leaf.prim_ids[i];
    hit.geom_id = mesh.geom_id;
    hit.mesh = mesh.index;
    if (kFiltered && !query.filter->accept(query.filter->user, query.ray, hit)) continue;
    found = true;
    if (kAnyHit) return true;
    *query.hit = hit;
    ray.tfar = hit.t;
    update_s_far(ray);
  }
  return false;
}

inline const std::byte* address(const StructureView& structure, Link link) {
  return structure.data + std::size_t{link & kLinkOffsetMask} * kUnitBytes;
}

/// All lines of what `link` leads to are asked for at once, `kBytes` from its start: once each, instructions
/// count too (docs/performance.md).
template <std::size_t kBytes>
inline void prefetch(const StructureView& structure, Link link) {
  const std::byte* data = address(structure, link);
  for (std::size_t line = 0; line < kBytes; line += 64) __builtin_prefetch(data + line);
}

/// For closest hits: the nearest of the children met; the others are pushed, the nearer the higher.
inline StackEntry nearest_child(const ChildHits& hits, const Link* children, StackEntry*& top) {
  alignas(32) float entries[kWidth];
  store(entries, hits.entry);
  unsigned bits = hits.bits;
  auto i = static_cast<unsigned>(__builtin_ctz(bits));
  StackEntry nearest{children[i], entries[i]};
  StackEntry* const first = top;
  while ((bits &= bits - 1) != 0) {
    i = static_cast<unsigned>(__builtin_ctz(bits));
    StackEntry entry{children[i], entries[i]};
    if (entry.s < nearest.s) std::swap(entry, nearest);
    StackEntry* slot = top++;
    for (; slot > first && slot[-1].s < entry.s; --slot) *slot = slot[-1];
    *slot = entry;
  }
  return nearest;
}

inline Link first_of(const Siblings& siblings) {
  return siblings.children[__builtin_ctz(siblings.bits)];
}

inline Link take_first(Siblings& siblings) {
  const Link first = first_of(siblings);
  siblings.bits &= siblings.bits - 1;
  return first;
}

/// How far a query for the closest hit has come; its stack and the hit stand elsewhere.
struct ClosestHitCursor {
  static constexpr std::size_t kStack =
      7 * kMaxLevels + 1;  // each level leaves at most seven siblings behind
  using Entry = StackEntry;

  StackEntry entry;  ///< comes next
  StackEntry* top;   ///< of the stack: the others, the nearer the higher
  bool found;

  void start(const StructureView& structure, const TraversalRay& ray, StackEntry* stack) {
    entry = {structure.root, ray.s_near};
    top = stack;
    found = false;
  }

  /// Does what comes next. False: nothing is left.
  template <typename Test, bool kFiltered, bool kCounted, typename Prefetch, typename Slabs>
  bool step(const StructureView& structure, const Query& query, TraversalRay& ray, const Slabs& slabs,
            StackEntry* stack) {
    const std::byte* data = address(structure, entry.link);
    const auto kind = static_cast<LinkKind>(entry.link >> kLinkKindShift);
    if (kind != LinkKind::kLeaf) {
      if (kCounted) ++query.counters->nodes;
      const Link* children = nullptr;
      const ChildHits hits = intersect_any_node<Test>(ray, slabs, kind, data, children);
      if (hits.bits != 0) {
        entry = nearest_child(hits, children, top);
        Prefetch::next(structure, entry.link);
        if (top != stack) Prefetch::after_next(structure, top[-1].link);
        return true;
      }
    } else {
      const auto& leaf = *reinterpret_cast<const LeafHeader*>(data);
      test_leaf<Test, false, kFiltered, kCounted>(structure, ray, leaf, query, found);
    }
    do {
      if (top == stack) return false;
      entry = *--top;
    } while (entry.s > ray.s_far);
    Prefetch::popped(structure, entry.link);
    if (top != stack) Prefetch::after_next(structure, top[-1].link);
    return true;
  }
};

/// The same of a query for any hit. Children are visited in the encoder's order: what is large and decides
/// soon comes first. Sorting them by distance would cost more than it saves (docs/performance.md).
struct AnyHitCursor {
  static constexpr std::size_t kStack = kMaxLevels + 1;
  using Entry = Siblings;

  Link link;      ///< comes next
  Siblings* top;  ///< of the stack
  bool found;

  void start(const StructureView& structure, const TraversalRay&, Siblings* stack) {
    link = structure.root;
    top = stack;
    found = false;
  }

  template <typename Test, bool kFiltered, bool kCounted, typename Prefetch, typename Slabs>
  bool step(const StructureView& structure, const Query& query, TraversalRay& ray, const Slabs& slabs,
            Siblings* stack) {
    const std::byte* data = address(structure, link);
    const auto kind = static_cast<LinkKind>(link >> kLinkKindShift);
    if (kind != LinkKind::kLeaf) {
      if (kCounted) ++query.counters->nodes;
      Siblings met;
      met.bits = intersect_any_node<Test>(ray, slabs, kind, data, met.children).bits;
      if (met.bits != 0) {
        link = take_first(met);
        Prefetch::next(structure, link);
        if (met.bits != 0) Prefetch::after_next(structure, first_of(met));
        *top = met;
        top += met.bits != 0;
        return true;
      }
    } else {
      const auto& leaf = *reinterpret_cast<const LeafHeader*>(data);
      if (test_leaf<Test, true, kFiltered, kCounted>(structure, ray, leaf, query, found)) return false;
    }
    if (top == stack) return false;
    Siblings& next = top[-1];
    link = take_first(next);
    Prefetch::popped(structure, link);
    if (next.bits != 0) Prefetch::after_next(structure, first_of(next));
    top -= next.bits == 0;
    return true;
  }
};

}  // namespace
}  // namespace stbvh
