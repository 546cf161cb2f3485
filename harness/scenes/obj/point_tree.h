/// Which points are near a triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "harness/scenes/obj/plane_points.h"

namespace stbvh::harness {

using Triangle2 = std::array<Vec2, 3>;

/// A tree of points that halves them along the direction in which they lie, with boxes in that direction:
/// few are looked at where they crowd, or lie in slanting rows along a triangle's edge.
class PointTree {
 public:
  /// Of `chosen` ones of the points.
  PointTree(const Polygon& points, std::vector<std::uint32_t> chosen);

  /// Does nothing where it is not there.
  void remove(std::uint32_t point);

  /// Whether one of the points that are left is a `hit`; all that are in the closed triangle, wound
  /// counterclockwise, are asked for before the answer is no.
  template <class Hit>
  bool any_near(const Triangle2& triangle, const Hit& hit) const {
    return !nodes_.empty() && any_below(1, triangle, hit);
  }

 private:
  /// The two below node i are 2 i and 2 i + 1. One of a single point has no box.
  struct Node {
    Vec2 centre, along, across;  ///< of its box; half as long as that is
    std::size_t begin, count;    ///< of order_
    std::size_t left;            ///< of these
  };

  void build(std::size_t node, std::size_t begin, std::size_t count);
  void rebuild(std::size_t node);
  void bound(Node& node) const;

  static double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
  static bool meets(const Node& box, const Triangle2& triangle);

  template <class Hit>
  bool any_below(std::size_t i, const Triangle2& triangle, const Hit& hit) const {
    const Node& node = nodes_[i];
    if (node.left == 0) return false;
    if (node.count == 1) return hit(order_[node.begin]);
    return meets(node, triangle) && (any_below(2 * i, triangle, hit) || any_below(2 * i + 1, triangle, hit));
  }

  const Polygon& points_;
  std::vector<std::uint32_t> order_;   ///< the points as the nodes have them
  double margin_;                      ///< of boxes: far more than the rounding of what is compared
  std::vector<Node> nodes_;            ///< from 1 on
  std::vector<std::size_t> place_of_;  ///< the node of each point, 0 where it is not there
};

}  // namespace stbvh::harness
