#include "layout/encoder.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "build/collapse.h"

namespace stbvh {

namespace {

/// Subtrees of fewer leaves are walked by one thread.
constexpr std::size_t kParallelLeaves = 4096;
constexpr float kInf = std::numeric_limits<float>::infinity();

LinkKind node_kind(const BinaryNode& node, std::span<BinaryNode* const> children) {
  bool moves = false;
  for (const BinaryNode* child : children) {
    if (!(child->range == node.range)) return LinkKind::kSpatialTemporalNode;
    moves = moves || !child->bounds.is_static();
  }
  return moves ? LinkKind::kLinearNode : LinkKind::kStaticNode;
}

std::size_t node_units(LinkKind kind) {
  constexpr std::size_t units[] = {sizeof(StaticNode) / kUnitBytes, sizeof(LinearNode) / kUnitBytes,
                                   sizeof(SpatialTemporalNode) / kUnitBytes};
  return units[static_cast<std::size_t>(kind)];
}

Link make_link(LinkKind kind, std::size_t unit) {
  return static_cast<Link>(unit) | (static_cast<Link>(kind) << kLinkKindShift);
}

/// One face of linear bounds as plane + (t - begin) * slope, evaluated in float with or without fma, outside
/// the line through (begin, at_begin) and (last, at_last) at every float t between. With m the larger
/// magnitude, rounding of duration, plane, slope, t - begin, product and sum stays below 10 * 2^-24 * m
/// (docs/algorithm.md).
struct Face {
  float plane, slope;
};
Face make_face(float at_begin, float at_last, float duration, bool upper) {
  const float outwards = upper ? kInf : -kInf;
  if (at_begin == at_last) return {at_begin, 0.0f};
  if (!(duration > 0.0f)) return {upper ? std::max(at_begin, at_last) : std::min(at_begin, at_last), 0.0f};
  const float largest = std::max(std::fabs(at_begin), std::fabs(at_last));
  const float pad = largest * 0x1p-20f + 4.0f * std::numeric_limits<float>::min();
  const float slope = static_cast<float>((static_cast<double>(at_last) - at_begin) / duration);
  if (!std::isfinite(slope)) return make_face(at_begin, at_last, 0.0f, upper);
  const float plane = std::nextafter(upper ? at_begin + pad : at_begin - pad, outwards);
  return {plane, slope};
}

void write_planes(const LinearBounds& bounds, float duration, std::size_t slot, float (*planes)[kWidth],
                  float (*slopes)[kWidth]) {
  const F32x4* corners[2][2] = {{&bounds.lower_begin, &bounds.lower_end},
                                {&bounds.upper_begin, &bounds.upper_end}};
  for (int upper = 0; upper < 2; ++upper) {
    for (int axis = 0; axis < 3; ++axis) {
      const Face face =
          make_face((*corners[upper][0])[axis], (*corners[upper][1])[axis], duration, upper != 0);
      planes[upper * 3 + axis][slot] = face.plane;
      if (slopes != nullptr) slopes[upper * 3 + axis][slot] = face.slope;
    }
  }
}

void clear_planes(float (*planes)[kWidth]) {
  for (int plane = 0; plane < kPlanes; ++plane) {
    std::fill_n(planes[plane], kWidth, plane < kUpperX ? kInf : -kInf);
  }
}

/// The order in which occlusion rays try the children they meet: what is large and decides soon comes first.
bool is_tried_before(const BinaryNode* a, const BinaryNode* b) {
  const auto promise = [](const BinaryNode* node) {
    return node->bounds.centre_area() / (1.0f + std::log2(static_cast<float>(node->subtree_leaves)));
  };
  return promise(a) > promise(b);
}

using Children = std::span<BinaryNode* const>;

void write_node(const BinaryNode& node, LinkKind kind, Children children, const Link* links, std::byte* out) {
  const auto duration = [](const BinaryNode& n) { return n.range.last - n.range.begin; };
  if (kind == LinkKind::kStaticNode) {
    StaticNode n{};
    clear_planes(n.planes);
    for (std::size_t i = 0; i < children.size(); ++i)
      write_planes(children[i]->bounds, 0.0f, i, n.planes, nullptr);
    std::copy_n(links, kWidth, n.children);
    std::memcpy(out, &n, sizeof n);
  } else if (kind == LinkKind::kLinearNode) {
    LinearNode n{};
    clear_planes(n.planes);
    for (std::size_t i = 0; i < children.size(); ++i) {
      write_planes(children[i]->bounds, duration(node), i, n.planes, n.slopes);
    }
    std::copy_n(links, kWidth, n.children);
    n.time_begin = node.range.begin;
    std::memcpy(out, &n, sizeof n);
  } else {
    SpatialTemporalNode n{};
    clear_planes(n.planes);
    for (std::size_t i = 0; i < children.size(); ++i) {
      write_planes(children[i]->bounds, duration(*children[i]), i, n.planes, n.slopes);
      n.time_begin[i] = children[i]->range.begin;
      n.time_last[i] = children[i]->range.last;
    }
    std::copy_n(links, kWidth, n.children);
    std::memcpy(out, &n, sizeof n);
  }
}

template <typename Body>
void for_each_child(bool parallel, std::size_t count, const Body& body) {
  if (parallel) {
    tbb::parallel_for(std::size_t{0}, count, body);
  } else {
    for (std::size_t i = 0; i < count; ++i) body(i);
  }
}

}  // namespace

void Encoder::Counts::add(const Counts& other) {
  for (std::size_t kind = 0; kind < 3; ++kind) {
    nodes[kind] += other.nodes[kind];
    node_children[kind] += other.node_children[kind];
  }
  inline_leaves += other.inline_leaves;
  indexed_leaves += other.indexed_leaves;
  leaf_triangles += other.leaf_triangles;
  leaf_units += other.leaf_units;
  depth = std::max(depth, other.depth);
}

Encoder::Encoder(const BuildContext& context, const BinaryTree& tree)
    : context_(context), root_(tree.root()) {
  if (root_ == nullptr) return;
  counts_ = measure(*root_);
  units_ = root_->units;
  if (units_ > kMaxUnits) throw std::length_error("structure larger than 32 GiB");
}

std::size_t Encoder::leaf_steps(const BinaryLeaf& leaf) const {
  return context_.meshes[leaf.mesh].is_static() ? 1 : leaf.segments.last - leaf.segments.first + 2;
}

bool Encoder::is_indexed(const BinaryLeaf& leaf) const {
  return leaf_steps(leaf) > context_.settings.max_inline_steps;
}

std::size_t Encoder::leaf_units(const BinaryLeaf& leaf) const {
  return (is_indexed(leaf) ? kIndexedLeafBytes : inline_leaf_bytes(leaf_steps(leaf))) / kUnitBytes;
}

Encoder::Counts Encoder::measure(BinaryNode& node) const {
  Counts counts;
  if (node.is_leaf()) {
    (is_indexed(*node.leaf) ? counts.indexed_leaves : counts.inline_leaves) = 1;
    counts.leaf_triangles = node.leaf->meshlet->triangle_count;
    counts.leaf_units = node.units = leaf_units(*node.leaf);
    return counts;
  }
  std::array<BinaryNode*, kWidth> children;
  const std::size_t count = wide_children(node, children);
  std::array<Counts, kWidth> child_counts;
  const bool parallel = node.subtree_leaves >= kParallelLeaves;
  for_each_child(parallel, count, [&](std::size_t i) { child_counts[i] = measure(*children[i]); });
  const LinkKind kind = node_kind(node, {children.data(), count});
  node.units = node_units(kind);
  for (std::size_t i = 0; i < count; ++i) {
    counts.add(child_counts[i]);
    node.units += children[i]->units;
  }
  ++counts.nodes[static_cast<std::size_t>(kind)];
  counts.node_children[static_cast<std::size_t>(kind)] += count;
  ++counts.depth;
  return counts;
}

Link Encoder::encode(std::byte* data) const {
  return encode_node(*root_, data, 0);
}

Link Encoder::encode_node(BinaryNode& node, std::byte* data, std::size_t unit) const {
  if (node.is_leaf()) {
    encode_leaf(*node.leaf, data + unit * kUnitBytes);
    return make_link(LinkKind::kLeaf, unit);
  }
  std::array<BinaryNode*, kWidth> children;
  const std::size_t count = wide_children(node, children);
  std::stable_sort(children.begin(), children.begin() + static_cast<std::ptrdiff_t>(count), is_tried_before);
  const LinkKind kind = node_kind(node, {children.data(), count});
  std::array<std::size_t, kWidth> units;
  std::size_t next = unit + node_units(kind);
  for (std::size_t i = 0; i < count; ++i) {
    units[i] = next;
    next += children[i]->units;
  }
  Link links[kWidth] = {};
  for_each_child(node.subtree_leaves >= kParallelLeaves, count,
                 [&](std::size_t i) { links[i] = encode_node(*children[i], data, units[i]); });
  write_node(node, kind, {children.data(), count}, links, data + unit * kUnitBytes);
  return make_link(kind, unit);
}

void Encoder::encode_leaf(const BinaryLeaf& leaf, std::byte* out) const {
  const BuildMesh& mesh = context_.meshes[leaf.mesh];
  LeafHeader header{};
  header.mesh = leaf.mesh;
  header.first_segment = static_cast<std::uint16_t>(leaf.segments.first);
  header.triangle_count = leaf.meshlet->triangle_count;
  header.indexed = is_indexed(leaf);
  std::memcpy(header.corners, leaf.meshlet->corners, sizeof header.corners);
  std::copy_n(leaf.meshlet->prims, leaf.meshlet->triangle_count, header.prim_ids);
  std::memcpy(out, &header, sizeof header);
  out += sizeof header;

  std::uint32_t vertices[kWidth];
  for (std::size_t slot = 0; slot < kWidth; ++slot) {
    vertices[slot] = leaf.meshlet->vertices[slot < leaf.meshlet->vertex_count ? slot : 0];
  }
  if (header.indexed) {
    std::memcpy(out, vertices, sizeof vertices);
    return;
  }
  for (std::size_t step = 0; step < leaf_steps(leaf); ++step) {
    StepVertices positions;
    for (std::size_t slot = 0; slot < kWidth; ++slot) {
      const Vec3f p = mesh.position(leaf.segments.first + step, vertices[slot]);
      positions.position[0][slot] = p.x;
      positions.position[1][slot] = p.y;
      positions.position[2][slot] = p.z;
    }
    std::memcpy(out, &positions, sizeof positions);
    out += sizeof positions;
  }
}

void Encoder::add_statistics(BuildStatistics& statistics) const {
  statistics.nodes = counts_.nodes;
  statistics.node_children = counts_.node_children;
  statistics.inline_leaves = counts_.inline_leaves;
  statistics.indexed_leaves = counts_.indexed_leaves;
  statistics.leaf_triangles = counts_.leaf_triangles;
  statistics.leaf_bytes = counts_.leaf_units * kUnitBytes;
  statistics.depth = counts_.depth;
}

}  // namespace stbvh
