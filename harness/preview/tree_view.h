/// Looking at the tree of a structure: boxes of a level at a time, and one subtree over all times.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "harness/images/image.h"
#include "harness/scenes/vec3.h"
#include "harness/scenes/scene.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

using Rgb = std::array<std::uint8_t, 3>;

/// A node or leaf at one time.
struct TreeBox {
  Box3f box;
  NodeKind kind = NodeKind::kStatic;
  bool is_timed = false;  ///< it is there for a part of the tree's time: something above was split in time
  TimeRange time_range;
};

/// Most boxes, and most nodes of a time line: more are neither seen nor drawn in time.
inline constexpr std::size_t kMostTreeNodes = 20'000;

struct TreeLevel {
  std::vector<TreeBox> boxes;
  bool is_complete = true;  ///< false: there are more than kMostTreeNodes
};

/// The nodes of level `level` of `tree` that rays of time `time` may come to, and the leaves above it.
TreeLevel boxes_at(const Structure& tree, std::size_t level, float time);

/// Of what is there for a part of the time, the colour of the middle of that part, from blue (the start) over
/// green to red (the end); else white where it moves, grey where it stands still.
Rgb tree_color(bool is_timed, TimeRange range, bool moves);

/// Draws the edges of `boxes` as `camera` sees them into `image`.
void draw_boxes(Image& image, const std::vector<TreeBox>& boxes, const Camera& camera);

/// Children taken on the way from the root to a node.
using TreePath = std::vector<std::size_t>;

/// The way to the leaf that holds triangle `prim_id` of mesh `geom_id` at `time`, where `point`, of the
/// triangle, lies then; empty if there is none (and where the root is that leaf).
TreePath path_to(const Structure& tree, std::uint32_t geom_id, std::uint32_t prim_id, float time, Vec3 point);

/// Bounds of a node along one axis, over the time that it is there: a quadrilateral in time and space.
struct TimeLineNode {
  TimeRange time_range;
  std::array<float, 2> at_begin{}, at_end{};  ///< lower and upper
  NodeKind kind = NodeKind::kStatic;
  bool is_timed = false;
};

struct TimeLine {
  TimeLineNode subtree;             ///< its root
  std::vector<TimeLineNode> nodes;  ///< those `depth` levels below, and leaves above them
  bool is_complete = true;
};

/// The node that the first `level` steps of `path` lead to, and what lies `depth` levels below, along `axis`
/// (0, 1, 2): temporal-spatial bounds as Woop et al. 2017 draw them.
TimeLine time_line(const Structure& tree, const TreePath& path, std::size_t level, std::size_t depth,
                   std::size_t axis);

}  // namespace stbvh::harness
