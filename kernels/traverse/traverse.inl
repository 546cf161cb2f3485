/// The traversal: closest hit and any hit, with and without filter and counters. `Test` is how rays are
/// tested against boxes and triangles: WatertightTest or FastTest.
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

template <typename Test, typename PlaneAt>
inline ChildHits intersect_children(const TraversalRay& ray, const PlaneAt& plane_at) {
  const auto near_at = [&](int i) {
    return Test::slab(plane_at(ray.planes->near[i]), ray.near_origin[i], ray.inverse[i]);
  };
  const auto far_at = [&](int i) {
    return Test::slab(plane_at(ray.planes->far[i]), ray.far_origin[i], ray.inverse[i]);
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

template <typename Test>
inline ChildHits intersect_node(const TraversalRay& ray, const StaticNode& node) {
  return intersect_children<Test>(ray, [&](std::uint32_t offset) { return load(plane(&node, offset)); });
}

template <typename Test>
inline ChildHits intersect_node(const TraversalRay& ray, const LinearNode& node) {
  const F32x8 elapsed = splat(ray.time - node.time_begin);
  return intersect_children<Test>(ray,
                                  [&](std::uint32_t offset) { return moving_plane(&node, offset, elapsed); });
}

template <typename Test>
inline ChildHits intersect_node(const TraversalRay& ray, const SpatialTemporalNode& node) {
  const F32x8 time = splat(ray.time);
  const F32x8 begin = load(node.time_begin);
  const F32x8 elapsed = time - begin;
  ChildHits hits = intersect_children<Test>(
      ray, [&](std::uint32_t offset) { return moving_plane(&node, offset, elapsed); });
  hits.bits &= less_equal(begin, time).bits & less_equal(time, load(node.time_last)).bits;
  return hits;
}

template <typename Test>
inline ChildHits intersect_any_node(const TraversalRay& ray, LinkKind kind, const std::byte* data,
                                    const Link*& children) {
  if (kind == LinkKind::kLinearNode) {
    const auto& node = *reinterpret_cast<const LinearNode*>(data);
    children = node.children;
    return intersect_node<Test>(ray, node);
  }
  if (kind == LinkKind::kStaticNode) {
    const auto& node = *reinterpret_cast<const StaticNode*>(data);
    children = node.children;
    return intersect_node<Test>(ray, node);
  }
  const auto& node = *reinterpret_cast<const SpatialTemporalNode*>(data);
  children = node.children;
  return intersect_node<Test>(ray, node);
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
    hit.mesh = leaf.mesh;
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

/// Traversal waits for memory most of the time. All lines of a node are asked for at once, as soon as it is
/// known that it comes next, or after next; once each: instructions count too (docs/performance.md).
template <std::size_t kBytes>
inline void prefetch(const StructureView& structure, Link link) {
  const std::byte* data = address(structure, link);
  for (std::size_t line = 0; line < kBytes; line += 64) __builtin_prefetch(data + line);
}

/// Of what comes next also the later steps of a long leaf, or the start of the child that stands behind it.
inline void prefetch_next(const StructureView& structure, Link link) {
  prefetch<640>(structure, link);
}
inline void prefetch_after_next(const StructureView& structure, Link link) {
  prefetch<sizeof(LinearNode)>(structure, link);
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

template <typename Test, bool kFiltered, bool kCounted>
bool find_closest_hit(const StructureView& structure, const Query& query) {
  TraversalRay ray;
  if (structure.empty || !setup_ray<Test>(structure, query.ray, ray)) return false;
  StackEntry stack[7 * kMaxLevels + 1];  // each level leaves at most seven siblings behind
  StackEntry* top = stack;
  StackEntry entry{structure.root, ray.s_near};
  bool found = false;
  for (;;) {
    const std::byte* data = address(structure, entry.link);
    const auto kind = static_cast<LinkKind>(entry.link >> kLinkKindShift);
    if (kind != LinkKind::kLeaf) {
      if (kCounted) ++query.counters->nodes;
      const Link* children = nullptr;
      const ChildHits hits = intersect_any_node<Test>(ray, kind, data, children);
      if (hits.bits != 0) {
        entry = nearest_child(hits, children, top);
        prefetch_next(structure, entry.link);
        if (top != stack) prefetch_after_next(structure, top[-1].link);
        continue;
      }
    } else {
      const auto& leaf = *reinterpret_cast<const LeafHeader*>(data);
      test_leaf<Test, false, kFiltered, kCounted>(structure, ray, leaf, query, found);
    }
    do {
      if (top == stack) return found;
      entry = *--top;
    } while (entry.s > ray.s_far);
    if (top != stack) prefetch_after_next(structure, top[-1].link);
  }
}

/// Children are visited in the encoder's order: what is large and decides soon comes first. Sorting them by
/// distance would cost more than it saves (docs/performance.md).
template <typename Test, bool kFiltered, bool kCounted>
bool find_any_hit(const StructureView& structure, const Query& query) {
  TraversalRay ray;
  if (structure.empty || !setup_ray<Test>(structure, query.ray, ray)) return false;
  Siblings stack[kMaxLevels + 1];
  Siblings* top = stack;
  Link link = structure.root;
  bool found = false;
  for (;;) {
    const std::byte* data = address(structure, link);
    const auto kind = static_cast<LinkKind>(link >> kLinkKindShift);
    if (kind != LinkKind::kLeaf) {
      if (kCounted) ++query.counters->nodes;
      Siblings met;
      met.bits = intersect_any_node<Test>(ray, kind, data, met.children).bits;
      if (met.bits != 0) {
        link = take_first(met);
        prefetch_next(structure, link);
        if (met.bits != 0) prefetch_after_next(structure, first_of(met));
        *top = met;
        top += met.bits != 0;
        continue;
      }
    } else {
      const auto& leaf = *reinterpret_cast<const LeafHeader*>(data);
      if (test_leaf<Test, true, kFiltered, kCounted>(structure, ray, leaf, query, found)) return true;
    }
    if (top == stack) return found;
    Siblings& next = top[-1];
    link = take_first(next);
    if (next.bits != 0) prefetch_after_next(structure, first_of(next));
    top -= next.bits == 0;
  }
}

template <typename Test>
constexpr KernelTable make_kernel_table() {
  return {
      [](const StructureView& s, const Ray& ray, Hit& hit) {
        return find_closest_hit<Test, false, false>(s, {ray, &hit, nullptr, nullptr});
      },
      [](const StructureView& s, const Ray& ray, Hit& hit, const HitFilter& filter) {
        return find_closest_hit<Test, true, false>(s, {ray, &hit, &filter, nullptr});
      },
      [](const StructureView& s, const Ray& ray, Hit& hit, TraversalCounters& counters) {
        return find_closest_hit<Test, false, true>(s, {ray, &hit, nullptr, &counters});
      },
      [](const StructureView& s, const Ray& ray) {
        return find_any_hit<Test, false, false>(s, {ray, nullptr, nullptr, nullptr});
      },
      [](const StructureView& s, const Ray& ray, const HitFilter& filter) {
        return find_any_hit<Test, true, false>(s, {ray, nullptr, &filter, nullptr});
      },
      [](const StructureView& s, const Ray& ray, TraversalCounters& counters) {
        return find_any_hit<Test, false, true>(s, {ray, nullptr, nullptr, &counters});
      },
  };
}

}  // namespace
}  // namespace stbvh
