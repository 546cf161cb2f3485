/// The nodes of a kd-tree over space and time, and who asks them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layout/layout.h"
#include "stbvh/structure.h"

namespace stbvh::harness::gallery {

/// What a node of the kd-tree splits; a cell is not split.
enum class KdAxis : std::uint32_t { kX, kY, kZ, kTime, kCell };

/// Most nodes above a cell: what the traversal's stack holds.
inline constexpr std::size_t kMostKdLevels = 64;

class KdNode {
 public:
  static constexpr std::size_t kMostPlaces = std::size_t{1} << 29;

  KdNode() = default;
  /// Splits at `position`: what is below it is in the node `first`, what is not in that behind it. A box may
  /// be in both.
  static KdNode inner(KdAxis axis, float position, std::size_t first) {
    KdNode node(axis, first);
    node.position_ = position;
    return node;
  }
  /// Holds `count` links from the link `first` on.
  static KdNode cell(std::size_t first, std::size_t count) {
    KdNode node(KdAxis::kCell, first);
    node.count_ = static_cast<std::uint32_t>(count);
    return node;
  }

  KdAxis axis() const { return static_cast<KdAxis>(axis_and_first_ & 7u); }
  std::uint32_t first() const { return axis_and_first_ >> 3; }
  float position() const { return position_; }
  std::uint32_t count() const { return count_; }
  /// The same node with its children or its links `places` further on.
  KdNode moved(std::size_t places) const {
    KdNode node = *this;
    node.axis_and_first_ += static_cast<std::uint32_t>(places) << 3;
    return node;
  }

 private:
  KdNode(KdAxis axis, std::size_t first)
      : axis_and_first_(static_cast<std::uint32_t>(axis) | static_cast<std::uint32_t>(first) << 3),
        count_(0) {}

  std::uint32_t axis_and_first_;
  union {
    float position_;
    std::uint32_t count_;
  };
};
static_assert(sizeof(KdNode) == 8);

/// A kd-tree as its traversal sees it: `lower` and `upper` bound the root's cell, `root` is not used.
struct KdView : StructureView {
  const KdNode* nodes;  ///< the root is the first
  const Link* links;    ///< of the cells, to the kernels' leaves
};

bool intersect_kd(const KdView& view, const Ray& ray, Hit& hit);
bool intersect_kd_counted(const KdView& view, const Ray& ray, Hit& hit, TraversalCounters& counters);
bool occluded_kd(const KdView& view, const Ray& ray);

}  // namespace stbvh::harness::gallery
