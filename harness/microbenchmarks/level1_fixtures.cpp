#include "harness/microbenchmarks/level1_fixtures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "harness/scenes/pcg32.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {
namespace {

constexpr float kTime = 0.4f;

Ray make_ray(Vec3f origin, Vec3f direction) {
  return {.origin = origin,
          .tnear = 0,
          .direction = direction,
          .time = kTime,
          .tfar = std::numeric_limits<float>::infinity(),
          .mask = 0xFFFFFFFFu};
}

/// What ray set-up reads: alive in [0, 1], everything within [-extent, extent]^3.
StructureView view_of(const void* data, float extent) {
  StructureView view{};
  view.data = static_cast<const std::byte*>(data);
  view.time_begin = 0;
  view.time_last = 1;
  std::fill_n(view.lower, 3, -extent);
  std::fill_n(view.upper, 3, extent);
  return view;
}

float between(Pcg32& random, double a, double b) {
  return static_cast<float>(random.uniform(a, b));
}

template <typename Node>
constexpr LinkKind kKindOf = std::is_same_v<Node, StaticNode>   ? LinkKind::kStaticNode
                             : std::is_same_v<Node, LinearNode> ? LinkKind::kLinearNode
                                                                : LinkKind::kSpatialTemporalNode;

}  // namespace

template <typename Node>
NodeRing<Node>::NodeRing()
    : structure(view_of(nodes, 3)), ray(make_ray({-2.1f, -1.9f, -2.3f}, {2, 2, 2.2f})) {
  Pcg32 random(1);
  for (std::size_t i = 0; i < kRing; ++i) {
    Node& node = nodes[i];
    for (std::size_t child = 0; child < kWidth; ++child) {
      for (std::size_t plane = 0; plane < kPlanes; ++plane) {
        const double outwards = plane < kUpperX ? -1.0 : 1.0;
        node.planes[plane][child] = between(random, 1.0, 2.0) * static_cast<float>(outwards);
        if constexpr (!std::is_same_v<Node, StaticNode>)
          node.slopes[plane][child] = between(random, -0.5, 0.5);
      }
      if constexpr (std::is_same_v<Node, SpatialTemporalNode>) node.time_last[child] = 1;
      const std::size_t next = (i + 1) % kRing * sizeof(Node) / kUnitBytes;
      node.children[child] = static_cast<Link>(next) | static_cast<Link>(kKindOf<Node>) << kLinkKindShift;
    }
  }
}

template struct NodeRing<StaticNode>;
template struct NodeRing<LinearNode>;
template struct NodeRing<SpatialTemporalNode>;

LeafRing::LeafRing(LeafKind kind) : structure_(view_of(slots_, 2)) {
  constexpr std::uint8_t kRim = 7;
  const bool is_static = kind == LeafKind::kInlineStatic;
  for (std::size_t i = 0; i < kRing; ++i) {
    Slot& slot = slots_[i];
    slot.header.triangle_count = kRim;
    slot.header.indexed = kind == LeafKind::kIndexed;
    std::uint32_t ids[kWidth];
    for (std::uint8_t v = 0; v < kWidth; ++v) {
      ids[v] = static_cast<std::uint32_t>(positions_[0].size());
      const double angle = 2 * kPi * v / kRim + 0.37 * static_cast<double>(i);
      const double radius = v == kRim ? 0.0 : 1.0;
      for (std::size_t k = 0; k < 2; ++k) {
        const double moved = 0.02 * static_cast<double>(k);
        const Vec3f p = to_float({radius * std::cos(angle) + moved, radius * std::sin(angle) - moved,
                                  0.05 * static_cast<double>(i) + moved});
        positions_[k].push_back(p);
        slot.steps[k].position[0][v] = p.x;
        slot.steps[k].position[1][v] = p.y;
        slot.steps[k].position[2][v] = p.z;
      }
    }
    for (std::uint8_t t = 0; t < kRim; ++t) {
      slot.header.corners[0][t] = kRim;
      slot.header.corners[1][t] = t;
      slot.header.corners[2][t] = static_cast<std::uint8_t>((t + 1) % kRim);
      slot.header.prim_ids[t] = static_cast<std::uint32_t>(triangles_.size());
      triangles_.push_back({ids[kRim], ids[t], ids[(t + 1) % kRim]});
    }
  }
  for (std::size_t k = 0; k < 2; ++k) steps_[k] = {positions_[k].data(), positions_[k].size(), sizeof(Vec3f)};
  constexpr float kInf = std::numeric_limits<float>::infinity();
  mesh_.grid = is_static ? TimeGrid{-kInf, kInf, kInf, 0.0f} : TimeGrid{0, 1, 1, 1};
  mesh_.mask = 0xFFFFFFFFu;
  mesh_.steps = steps_;
  mesh_.indices = triangles_.data();
  mesh_.index_stride = sizeof(TriangleIndices);
  structure_.meshes = &mesh_;
}

Ray LeafRing::hitting_ray() {
  return make_ray({0.3f, 0.25f, -2}, {0.02f, 0.01f, 1});
}

Ray LeafRing::missing_ray() {
  return make_ray({1.6f, 0.25f, -2}, {0.02f, 0.01f, 1});
}

RayRing::RayRing() : structure(view_of(nullptr, 2)) {
  Pcg32 random(2);
  for (Ray& ray : rays) {
    float x[6];
    for (float& coordinate : x) coordinate = between(random, -1, 1);
    ray = make_ray({x[0], x[1], x[2]}, {x[3], x[4], x[5]});
  }
}

}  // namespace stbvh::harness
