/// The steps of the traversal, each in a loop of its own: one node, one leaf, the set-up of one ray.
#pragma once

#include <cstddef>

#include "harness/microbenchmarks/level1_fixtures.h"

namespace stbvh::harness {

/// Each does `count` nodes, one after another around the ring.
template <typename Node>
struct NodeSteps {
  /// Nodes that do not depend on each other. Returns how many of their boxes were met.
  std::size_t (*throughput)(const NodeRing<Node>& ring, std::size_t count);
  /// Each node is found through a link of the last one, that of the first box met, as any-hit traversal does.
  std::size_t (*latency)(const NodeRing<Node>& ring, std::size_t count);
};

/// The steps with one test of boxes and triangles.
struct TraversalSteps {
  NodeSteps<StaticNode> static_node;
  NodeSteps<LinearNode> linear_node;
  NodeSteps<SpatialTemporalNode> spatial_temporal_node;

  /// `count` leaves, each on its own: what was hit before does not shorten the ray. Return how many were hit.
  std::size_t (*closest_hit)(const LeafRing& ring, const Ray& ray, std::size_t count);
  std::size_t (*any_hit)(const LeafRing& ring, const Ray& ray, std::size_t count);

  /// Sets up `count` rays; returns how many of them may hit anything.
  std::size_t (*setup_ray)(const RayRing& ring, std::size_t count);
};

/// Only for machines with AVX2 and FMA.
extern const TraversalSteps kAvx2WatertightSteps;
extern const TraversalSteps kAvx2FastSteps;

}  // namespace stbvh::harness
