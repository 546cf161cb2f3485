// The traversal: closest hit and any hit, with and without filter and counters. Part of the traversal
// sources.

/// Each level leaves at most seven siblings behind; the builder keeps trees below 90 levels.
constexpr std::size_t kStackSize = 7 * 90 + 1;

struct StackEntry {
  Link link;
  float s;  ///< where the ray enters the box; not used for any hit
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

template <typename PlaneAt>
inline ChildHits intersect_children(const TraversalRay& ray, const PlaneAt& plane_at) {
  const auto near_at = [&](int i) {
    return (plane_at(ray.near_plane[i]) - splat(ray.near_origin[i])) * splat(ray.inverse[i]);
  };
  const auto far_at = [&](int i) {
    return (plane_at(ray.far_plane[i]) - splat(ray.far_origin[i])) * splat(ray.inverse[i]);
  };
  const F32x8 entry = max(max(near_at(0), near_at(1)), max(near_at(2), splat(ray.s_near)));
  const F32x8 exit = min(min(far_at(0), far_at(1)), min(far_at(2), splat(ray.s_far)));
  return {entry, less_equal(entry, exit).bits};
}

inline ChildHits intersect_node(const TraversalRay& ray, const StaticNode& node) {
  return intersect_children(ray, [&](std::size_t plane) { return load(node.planes[plane]); });
}

inline ChildHits intersect_node(const TraversalRay& ray, const LinearNode& node) {
  const F32x8 elapsed = splat(ray.time - node.time_begin);
  return intersect_children(ray, [&](std::size_t plane) {
    return multiply_add(elapsed, load(node.slopes[plane]), load(node.planes[plane]));
  });
}

inline ChildHits intersect_node(const TraversalRay& ray, const SpatialTemporalNode& node) {
  const F32x8 time = splat(ray.time);
  const F32x8 begin = load(node.time_begin);
  const F32x8 elapsed = time - begin;
  ChildHits hits = intersect_children(ray, [&](std::size_t plane) {
    return multiply_add(elapsed, load(node.slopes[plane]), load(node.planes[plane]));
  });
  hits.bits &= less_equal(begin, time).bits & less_equal(time, load(node.time_last)).bits;
  return hits;
}

inline ChildHits intersect_any_node(const TraversalRay& ray, LinkKind kind, const std::byte* data,
                                    const Link*& children) {
  if (kind == LinkKind::kLinearNode) {
    const auto& node = *reinterpret_cast<const LinearNode*>(data);
    children = node.children;
    return intersect_node(ray, node);
  }
  if (kind == LinkKind::kStaticNode) {
    const auto& node = *reinterpret_cast<const StaticNode*>(data);
    children = node.children;
    return intersect_node(ray, node);
  }
  const auto& node = *reinterpret_cast<const SpatialTemporalNode*>(data);
  children = node.children;
  return intersect_node(ray, node);
}

/// Tests a leaf. True: traversal may end (any hit found).
template <bool kAnyHit, bool kFiltered, bool kCounted>
inline bool test_leaf(const StructureView& structure, TraversalRay& ray, const LeafHeader& leaf,
                      const Query& query, bool& found) {
  const MeshRecord& mesh = structure.meshes[leaf.mesh];
  if ((mesh.mask & ray.mask) == 0 || !(ray.time >= mesh.grid.begin && ray.time <= mesh.grid.end))
    return false;
  if (kCounted) {
    ++query.counters->leaves;
    query.counters->triangle_tests += leaf.triangle_count;
  }
  ShearedVertices s;
  for (unsigned bits = candidates(ray, leaf, load_leaf(ray, leaf, mesh), s); bits != 0; bits &= bits - 1) {
    const auto i = static_cast<unsigned>(__builtin_ctz(bits));
    Hit hit;
    if (!decide(ray, leaf, s, i, hit.t, hit.u, hit.v)) continue;
    if (!(hit.t > ray.tnear && hit.t <= ray.tfar)) continue;
    if (kAnyHit && !kFiltered) return found = true;
    hit.normal = triangle_normal(ray, leaf, s, i);
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

/// Traversal waits for memory most of the time: all lines of the node entered are asked for at once, and what
/// comes after it early. (Worth 5 to 15 % on the built-in scenes; docs/performance.md.)
inline void prefetch(const std::byte* node_or_leaf) {
  for (std::size_t line = 0; line < sizeof(LinearNode); line += 64) __builtin_prefetch(node_or_leaf + line);
}

inline const std::byte* address(const StructureView& structure, Link link) {
  return structure.data + std::size_t{link & kLinkOffsetMask} * kUnitBytes;
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

/// For any hit: the first of the children met, the others pushed, in the encoder's order: what is large and
/// decides soon comes first. Sorting by distance would cost more than it saves (docs/performance.md).
inline StackEntry first_child(const ChildHits& hits, const Link* children, StackEntry*& top) {
  unsigned bits = hits.bits;
  while ((bits & (bits - 1)) != 0) {
    const auto last = 31u - static_cast<unsigned>(__builtin_clz(bits));
    *top++ = {children[last], 0.0f};
    bits ^= 1u << last;
  }
  return {children[__builtin_ctz(bits)], 0.0f};
}

template <bool kAnyHit, bool kFiltered, bool kCounted>
bool traverse(const StructureView& structure, const Query& query) {
  TraversalRay ray;
  if (structure.empty || !setup_ray(structure, query.ray, ray)) return false;
  StackEntry stack[kStackSize];
  StackEntry* top = stack;
  StackEntry entry{structure.root, ray.s_near};
  bool found = false;
  for (;;) {
    const std::byte* data = address(structure, entry.link);
    const auto kind = static_cast<LinkKind>(entry.link >> kLinkKindShift);
    if (kind != LinkKind::kLeaf) {
      if (kCounted) ++query.counters->nodes;
      prefetch(data);
      const Link* children = nullptr;
      const ChildHits hits = intersect_any_node(ray, kind, data, children);
      if (hits.bits != 0) {
        entry = kAnyHit ? first_child(hits, children, top) : nearest_child(hits, children, top);
        for (int ahead = 1; ahead <= 2 && top - stack >= ahead; ++ahead)
          prefetch(address(structure, top[-ahead].link));
        continue;
      }
    } else {
      const auto& leaf = *reinterpret_cast<const LeafHeader*>(data);
      if (test_leaf<kAnyHit, kFiltered, kCounted>(structure, ray, leaf, query, found)) return true;
    }
    do {
      if (top == stack) return found;
      entry = *--top;
    } while (!kAnyHit && entry.s > ray.s_far);
  }
}

constexpr KernelTable make_kernel_table() {
  return {
      [](const StructureView& s, const Ray& ray, Hit& hit) {
        return traverse<false, false, false>(s, {ray, &hit, nullptr, nullptr});
      },
      [](const StructureView& s, const Ray& ray, Hit& hit, const HitFilter& filter) {
        return traverse<false, true, false>(s, {ray, &hit, &filter, nullptr});
      },
      [](const StructureView& s, const Ray& ray, Hit& hit, TraversalCounters& counters) {
        return traverse<false, false, true>(s, {ray, &hit, nullptr, &counters});
      },
      [](const StructureView& s, const Ray& ray) {
        return traverse<true, false, false>(s, {ray, nullptr, nullptr, nullptr});
      },
      [](const StructureView& s, const Ray& ray, const HitFilter& filter) {
        return traverse<true, true, false>(s, {ray, nullptr, &filter, nullptr});
      },
      [](const StructureView& s, const Ray& ray, TraversalCounters& counters) {
        return traverse<true, false, true>(s, {ray, nullptr, nullptr, &counters});
      },
  };
}
