#include "layout/encoder.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "builder/collapse.h"
#include "builder/mbsah.h"

namespace stbvh {

namespace {

/// Subtrees of fewer leaves are walked by one thread.
constexpr std::size_t kParallelLeaves = 4096;
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr std::uint32_t kNone = 0xFFFFFFFFu;

LinkKind node_kind(const BinaryNode& node, std::span<BinaryNode* const> children) {
  bool moves = false;
  for (const BinaryNode* child : children) {
    if (!(child->range == node.range)) return LinkKind::kSpatialTemporalNode;
    moves = moves || !child->bounds().is_static();
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
    return node->bounds().centre_area() / (1.0f + std::log2(static_cast<float>(node->subtree_leaves)));
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
      write_planes(children[i]->bounds(), 0.0f, i, n.planes, nullptr);
    std::copy_n(links, kWidth, n.children);
    std::memcpy(out, &n, sizeof n);
  } else if (kind == LinkKind::kLinearNode) {
    LinearNode n{};
    clear_planes(n.planes);
    for (std::size_t i = 0; i < children.size(); ++i) {
      write_planes(children[i]->bounds(), duration(node), i, n.planes, n.slopes);
    }
    std::copy_n(links, kWidth, n.children);
    n.time_begin = node.range.begin;
    std::memcpy(out, &n, sizeof n);
  } else {
    SpatialTemporalNode n{};
    clear_planes(n.planes);
    for (std::size_t i = 0; i < children.size(); ++i) {
      write_planes(children[i]->bounds(), duration(*children[i]), i, n.planes, n.slopes);
      n.time_begin[i] = children[i]->range.begin;
      n.time_last[i] = children[i]->range.last;
    }
    std::copy_n(links, kWidth, n.children);
    std::memcpy(out, &n, sizeof n);
  }
}

LeafHeader leaf_header(std::uint32_t mesh, const Meshlet& meshlet) {
  LeafHeader header{};
  header.mesh = mesh;
  header.triangle_count = meshlet.triangle_count;
  std::memcpy(header.corners, meshlet.corners, sizeof header.corners);
  std::copy_n(meshlet.prims, meshlet.triangle_count, header.prim_ids);
  return header;
}

/// Unused slots repeat the first vertex.
std::array<std::uint32_t, kWidth> vertex_slots(const Meshlet& meshlet) {
  std::array<std::uint32_t, kWidth> vertices;
  vertices.fill(meshlet.vertices[0]);
  std::copy_n(meshlet.vertices, meshlet.vertex_count, vertices.begin());
  return vertices;
}

void encode_indexed_leaf(std::uint32_t mesh, const Meshlet& meshlet, std::byte* out) {
  LeafHeader header = leaf_header(mesh, meshlet);
  header.indexed = 1;
  std::memcpy(out, &header, sizeof header);
  const std::array<std::uint32_t, kWidth> vertices = vertex_slots(meshlet);
  std::memcpy(out + sizeof header, vertices.data(), sizeof vertices);
}

/// A leaf by what each of its bytes brings to rays; of equal ones the first in the tree comes first.
struct RankedLeaf {
  float worth;
  std::uint32_t index;

  bool operator<(const RankedLeaf& other) const {
    return worth != other.worth ? worth > other.worth : index < other.index;
  }
};

void collect_leaves(BinaryNode& node, std::vector<BinaryLeaf*>& leaves) {
  if (node.is_leaf()) {
    leaves.push_back(static_cast<BinaryLeaf*>(&node));
    return;
  }
  for (BinaryNode* child : as_inner(node).children) collect_leaves(*child, leaves);
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
  choose_leaves();
  counts_ = measure(*root_);
  units_ = root_->units;
  if (bytes() > kMaxUnits * kUnitBytes) throw std::length_error("structure larger than 32 GiB");
}

void Encoder::choose_leaves() {
  const float share = context_.settings.inline_share;
  if (share >= 1.0f) return;
  std::vector<BinaryLeaf*> leaves;
  collect_leaves(*root_, leaves);
  const auto bytes = [&](const BinaryLeaf* leaf) { return inline_leaf_bytes(leaf_steps(*leaf)); };
  std::vector<RankedLeaf> ranked(leaves.size());
  double left = 0;
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    const auto size = static_cast<float>(bytes(leaves[i]));
    ranked[i] = {expected_area(leaves[i]->bounds(), leaves[i]->range) / size, i};
    left += static_cast<double>(size) * share;
  }
  tbb::parallel_sort(ranked.begin(), ranked.end());
  std::size_t meshlets = 0;
  for (const MeshletSet& set : context_.meshlets) {
    first_meshlet_.push_back(meshlets);
    meshlets += set.meshlets().size();
  }
  indexed_.assign(meshlets, kNone);
  for (const RankedLeaf& rank : ranked) {
    BinaryLeaf* const leaf = leaves[rank.index];
    const auto size = static_cast<double>(bytes(leaf));
    leaf->is_indexed = size > left;
    if (leaf->is_indexed) {
      indexed_[meshlet_number(*leaf)] = 0;
    } else {
      left -= size;
    }
  }
  for (std::uint32_t& number : indexed_) {
    if (number != kNone) number = static_cast<std::uint32_t>(indexed_count_++);
  }
}

std::size_t Encoder::leaf_steps(const BinaryLeaf& leaf) const {
  return context_.meshes[leaf.mesh].is_static() ? 1 : leaf.segments.last - leaf.segments.first + 2;
}

std::size_t Encoder::meshlet_number(const BinaryLeaf& leaf) const {
  return first_meshlet_[leaf.mesh] +
         static_cast<std::size_t>(leaf.meshlet - context_.meshlets[leaf.mesh].meshlets().data());
}

std::size_t Encoder::leaf_units(const BinaryLeaf& leaf) const {
  return leaf.is_indexed ? 0 : inline_leaf_bytes(leaf_steps(leaf)) / kUnitBytes;
}

Encoder::Counts Encoder::measure(BinaryNode& node) const {
  Counts counts;
  if (node.is_leaf()) {
    const BinaryLeaf& leaf = as_leaf(node);
    (leaf.is_indexed ? counts.indexed_leaves : counts.inline_leaves) = 1;
    counts.leaf_triangles = leaf.meshlet->triangle_count;
    counts.leaf_units = leaf_units(leaf);
    node.units = static_cast<std::uint32_t>(counts.leaf_units);
    return counts;
  }
  std::array<BinaryNode*, kWidth> children;
  const std::size_t count = wide_children(as_inner(node), children);
  std::array<Counts, kWidth> child_counts;
  const bool parallel = node.subtree_leaves >= kParallelLeaves;
  for_each_child(parallel, count, [&](std::size_t i) { child_counts[i] = measure(*children[i]); });
  const LinkKind kind = node_kind(node, {children.data(), count});
  std::size_t units = node_units(kind);
  for (std::size_t i = 0; i < count; ++i) {
    counts.add(child_counts[i]);
    units += children[i]->units;
  }
  node.units = static_cast<std::uint32_t>(std::min(units, kMaxUnits + 1));  // more is refused in the end
  ++counts.nodes[static_cast<std::size_t>(kind)];
  counts.node_children[static_cast<std::size_t>(kind)] += count;
  ++counts.depth;
  return counts;
}

Link Encoder::encode(std::byte* data) const {
  for (std::size_t mesh = 0; mesh < first_meshlet_.size(); ++mesh) {
    const std::span<const Meshlet> meshlets = context_.meshlets[mesh].meshlets();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, meshlets.size(), kParallelLeaves),
                      [&](const auto& part) {
                        for (std::size_t i = part.begin(); i != part.end(); ++i) {
                          const std::uint32_t number = indexed_[first_meshlet_[mesh] + i];
                          if (number == kNone) continue;
                          encode_indexed_leaf(static_cast<std::uint32_t>(mesh), meshlets[i],
                                              data + units_ * kUnitBytes + number * kIndexedLeafBytes);
                        }
                      });
  }
  return encode_node(*root_, data, 0);
}

Link Encoder::encode_node(const BinaryNode& node, std::byte* data, std::size_t unit) const {
  if (node.is_leaf()) {
    const BinaryLeaf& leaf = as_leaf(node);
    if (leaf.is_indexed) {
      const std::size_t number = indexed_[meshlet_number(leaf)];
      return make_link(LinkKind::kLeaf, units_ + number * (kIndexedLeafBytes / kUnitBytes));
    }
    encode_inline_leaf(leaf, data + unit * kUnitBytes);
    return make_link(LinkKind::kLeaf, unit);
  }
  std::array<BinaryNode*, kWidth> children;
  const std::size_t count = wide_children(as_inner(node), children);
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

void Encoder::encode_inline_leaf(const BinaryLeaf& leaf, std::byte* out) const {
  const BuildMesh& mesh = context_.meshes[leaf.mesh];
  LeafHeader header = leaf_header(leaf.mesh, *leaf.meshlet);
  header.first_segment = static_cast<std::uint16_t>(leaf.segments.first);
  std::memcpy(out, &header, sizeof header);
  out += sizeof header;
  const std::array<std::uint32_t, kWidth> vertices = vertex_slots(*leaf.meshlet);
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
  statistics.leaf_bytes = counts_.leaf_units * kUnitBytes + indexed_count_ * kIndexedLeafBytes;
  statistics.depth = counts_.depth;
}

}  // namespace stbvh
