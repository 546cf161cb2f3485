#include "harness/preview/tree_view.h"

#include <algorithm>
#include <cmath>

#include "harness/preview/line_drawing.h"

namespace stbvh::harness {
namespace {

bool is_alive(const TreeNode& node, float time) {
  return time >= node.time_range.begin && time <= node.time_range.end;
}

bool differs(TimeRange a, TimeRange b) {
  return a.begin != b.begin || a.end != b.end;
}

class LevelCollector final : public NodeVisitor {
 public:
  LevelCollector(std::size_t level, float time) : level_(level), time_(time) {}

  bool enter(const TreeNode& node) override {
    if (node.level == 0) whole_ = node.time_range;
    if (!is_alive(node, time_)) return false;
    if (node.level < level_ && !is_leaf(node.kind)) return true;
    if (found_.boxes.size() < kMostTreeNodes) {
      found_.boxes.push_back(
          {node.box.at(time_), node.kind, differs(node.time_range, whole_), node.time_range});
    } else {
      found_.is_complete = false;
    }
    return false;
  }
  TreeLevel take() { return std::move(found_); }

 private:
  std::size_t level_;
  float time_;
  TimeRange whole_;
  TreeLevel found_;
};

/// Follows the boxes that hold a point down to the leaf with a triangle.
class PathFinder final : public NodeVisitor {
 public:
  PathFinder(std::uint32_t geom_id, std::uint32_t prim_id, float time, Vec3 point)
      : geom_id_(geom_id), prim_id_(prim_id), time_(time), point_(point) {}

  bool enter(const TreeNode& node) override {
    if (is_found_) return false;
    if (node.level > 0) {
      counts_.resize(node.level + 1);
      path_.resize(node.level - 1);
      path_.push_back(counts_[node.level]++);
    }
    if (!is_alive(node, time_) || !holds(node.box.at(time_))) return false;
    if (!is_leaf(node.kind)) {
      counts_.resize(node.level + 1);  // its children are counted from 0
      return true;
    }
    is_found_ = node.geom_id == geom_id_ &&
                std::find(node.prim_ids.begin(), node.prim_ids.end(), prim_id_) != node.prim_ids.end();
    return false;
  }
  TreePath take() { return is_found_ ? path_ : TreePath{}; }

 private:
  /// With some rounding: the point was found along a ray.
  bool holds(const Box3f& box) const {
    const auto within = [](double p, float lower, float upper) {
      const double slack = 1e-4 * (std::abs(p) + static_cast<double>(upper) - lower);
      return p >= lower - slack && p <= upper + slack;
    };
    return within(point_.x, box.lower.x, box.upper.x) && within(point_.y, box.lower.y, box.upper.y) &&
           within(point_.z, box.lower.z, box.upper.z);
  }

  std::uint32_t geom_id_, prim_id_;
  float time_;
  Vec3 point_;
  std::vector<std::size_t>
      counts_;  ///< children met so far, of the nodes on the way, by the children's level
  TreePath path_;
  bool is_found_ = false;
};

std::array<float, 2> extent(const Box3f& box, std::size_t axis) {
  if (axis == 0) return {box.lower.x, box.upper.x};
  if (axis == 1) return {box.lower.y, box.upper.y};
  return {box.lower.z, box.upper.z};
}

class TimeLineCollector final : public NodeVisitor {
 public:
  TimeLineCollector(const TreePath& path, std::size_t level, std::size_t depth, std::size_t axis)
      : path_(path), level_(std::min(level, path.size())), depth_(depth), axis_(axis) {}

  bool enter(const TreeNode& node) override {
    if (node.level == 0) whole_ = node.time_range;
    if (node.level > 0 && node.level <= level_) {
      if (node.level != on_way_ + 1 || path_[node.level - 1] != count_++) return false;
      on_way_ = node.level;
      count_ = 0;
    }
    if (node.level < level_) return true;
    if (node.level == level_) line_.subtree = line_node(node);
    if (node.level < level_ + depth_ && !is_leaf(node.kind)) return true;
    if (line_.nodes.size() < kMostTreeNodes) {
      line_.nodes.push_back(line_node(node));
    } else {
      line_.is_complete = false;
    }
    return false;
  }
  TimeLine take() { return std::move(line_); }

 private:
  TimeLineNode line_node(const TreeNode& node) const {
    return {node.time_range, extent(node.box.at(node.time_range.begin), axis_),
            extent(node.box.at(node.time_range.end), axis_), node.kind, differs(node.time_range, whole_)};
  }

  const TreePath& path_;
  std::size_t level_, depth_, axis_;
  std::size_t on_way_ = 0;  ///< level of the last node of the way that was met
  std::size_t count_ = 0;   ///< of its children met so far
  TimeRange whole_;
  TimeLine line_;
};

}  // namespace

TreeLevel boxes_at(const Structure& tree, std::size_t level, float time) {
  LevelCollector collector(level, time);
  tree.visit_nodes(collector);
  return collector.take();
}

TreePath path_to(const Structure& tree, std::uint32_t geom_id, std::uint32_t prim_id, float time,
                 Vec3 point) {
  PathFinder finder(geom_id, prim_id, time, point);
  tree.visit_nodes(finder);
  return finder.take();
}

TimeLine time_line(const Structure& tree, const TreePath& path, std::size_t level, std::size_t depth,
                   std::size_t axis) {
  TimeLineCollector collector(path, level, depth, axis);
  tree.visit_nodes(collector);
  return collector.take();
}

Rgb tree_color(bool is_timed, TimeRange range, bool moves) {
  if (!is_timed) return moves ? Rgb{235, 235, 235} : Rgb{130, 130, 130};
  const double hue = 4 * (1 - std::clamp(0.5 * (static_cast<double>(range.begin) + range.end), 0.0, 1.0));
  const auto part = [hue](double centre) {  // of the six sextants of the colour circle
    const double away = std::min(std::abs(hue - centre), 6 - std::abs(hue - centre));
    return static_cast<std::uint8_t>(60 + 195 * std::clamp(2 - away, 0.0, 1.0));
  };
  return {part(0), part(2), part(4)};
}

void draw_boxes(Image& image, const std::vector<TreeBox>& boxes, const Camera& camera) {
  LineDrawing drawing(image, camera);
  for (const TreeBox& b : boxes) {
    const Rgb rgb = tree_color(b.is_timed, b.time_range, b.kind != NodeKind::kStatic);
    const auto corner = [&b](unsigned i) {
      return Vec3{(i & 1) != 0 ? b.box.upper.x : b.box.lower.x, (i & 2) != 0 ? b.box.upper.y : b.box.lower.y,
                  (i & 4) != 0 ? b.box.upper.z : b.box.lower.z};
    };
    for (unsigned i = 0; i < 8; ++i) {
      for (unsigned axis = 1; axis < 8; axis *= 2) {
        if ((i & axis) == 0) drawing.line(corner(i), corner(i | axis), rgb);
      }
    }
  }
}

}  // namespace stbvh::harness
