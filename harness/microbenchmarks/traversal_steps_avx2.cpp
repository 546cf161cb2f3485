// Includes the traversal as traverse_avx2.cpp does. No header whose inline functions other sources use at run
// time: the linker could give them this one's.
#include "simd/f32x8_avx2.h"  // before the traversal, which is then made of it

#include "harness/microbenchmarks/traversal_steps.h"
#include "traverse/steps.inl"

namespace stbvh::harness {
namespace {

/// The compiler must work these out.
inline void keep(const F32x8& value) {
  asm volatile("" : : "x"(value.v));
}
template <typename T>
inline void keep(const T& value) {
  asm volatile("" : : "m"(value));
}

/// The compiler must not know what is in `ray`.
inline void hide(TraversalRay& ray) {
  asm volatile("" : "+m"(ray));
}

inline std::size_t boxes_met(const ChildHits& hits) {
  return static_cast<std::size_t>(__builtin_popcount(hits.bits));
}

template <typename Test, typename Node>
std::size_t node_throughput(const NodeRing<Node>& ring, std::size_t count) {
  TraversalRay ray;
  if (!setup_ray<Test>(ring.structure, ring.ray, ray)) return 0;
  hide(ray);
  const KeptSlabs slabs(ray);
  std::size_t met = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const ChildHits hits = intersect_node<Test>(ray, slabs, ring.nodes[i % kRing]);
    keep(hits.entry);
    met += boxes_met(hits);
  }
  return met;
}

template <typename Test, typename Node>
std::size_t node_latency(const NodeRing<Node>& ring, std::size_t count) {
  TraversalRay ray;
  if (!setup_ray<Test>(ring.structure, ring.ray, ray)) return 0;
  hide(ray);
  const KeptSlabs slabs(ray);
  std::size_t met = 0;
  Link link = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& node = *reinterpret_cast<const Node*>(address(ring.structure, link));
    const ChildHits hits = intersect_node<Test>(ray, slabs, node);
    keep(hits.entry);
    met += boxes_met(hits);
    if (hits.bits == 0) break;
    link = node.children[__builtin_ctz(hits.bits)];
  }
  return met;
}

template <typename Test, bool kAnyHit>
std::size_t leaves(const LeafRing& ring, const Ray& query_ray, std::size_t count) {
  TraversalRay ray;
  if (!setup_ray<Test>(ring.structure(), query_ray, ray)) return 0;
  hide(ray);
  const float tfar = ray.tfar, s_far = ray.s_far;
  Hit hit{};
  const Query query{query_ray, kAnyHit ? nullptr : &hit, nullptr, nullptr};
  std::size_t hits = 0;
  for (std::size_t i = 0; i < count; ++i) {
    bool found = false;
    test_leaf<Test, kAnyHit, false, false>(ring.structure(), ray, ring.leaf(i), query, found);
    hits += found;
    if constexpr (!kAnyHit) {
      keep(hit);
      keep(ray.s_far);
      ray.tfar = tfar;
      ray.s_far = s_far;
    }
  }
  return hits;
}

template <typename Test>
std::size_t set_up_rays(const RayRing& ring, std::size_t count) {
  std::size_t alive = 0;
  for (std::size_t i = 0; i < count; ++i) {
    TraversalRay ray;
    alive += setup_ray<Test>(ring.structure, ring.rays[i % kRing], ray);
    keep(ray);
  }
  return alive;
}

template <typename Test, typename Node>
constexpr NodeSteps<Node> make_node_steps() {
  return {node_throughput<Test, Node>, node_latency<Test, Node>};
}

template <typename Test>
constexpr TraversalSteps make_steps() {
  return {make_node_steps<Test, StaticNode>(),
          make_node_steps<Test, LinearNode>(),
          make_node_steps<Test, SpatialTemporalNode>(),
          leaves<Test, false>,
          leaves<Test, true>,
          set_up_rays<Test>};
}

}  // namespace

const TraversalSteps kAvx2WatertightSteps = make_steps<WatertightTest>();
const TraversalSteps kAvx2FastSteps = make_steps<FastTest>();

}  // namespace stbvh::harness
