#include "harness/scenes/obj/point_tree.h"

#include <bit>
#include <limits>
#include <utility>

namespace stbvh::harness {

PointTree::PointTree(const Polygon& points, std::vector<std::uint32_t> chosen)
    : points_(points),
      order_(std::move(chosen)),
      margin_(0x1p-20 * rounding_of(points)),
      place_of_(points.size(), 0) {
  if (order_.empty()) return;
  nodes_.resize(2 * std::bit_ceil(order_.size()));
  build(1, 0, order_.size());
}

void PointTree::build(std::size_t i, std::size_t begin, std::size_t count) {
  Node& node = nodes_[i];
  node.begin = begin;
  node.count = node.left = count;
  if (count == 1) {
    place_of_[order_[begin]] = i;
    return;
  }
  bound(node);
  const Vec2 axis = dot(node.along, node.along) > dot(node.across, node.across) ? node.along : node.across;
  const auto first = order_.begin() + static_cast<std::ptrdiff_t>(begin);
  std::nth_element(
      first, first + static_cast<std::ptrdiff_t>(count / 2), first + static_cast<std::ptrdiff_t>(count),
      [&](std::uint32_t a, std::uint32_t b) { return dot(axis, points_[a]) < dot(axis, points_[b]); });
  build(2 * i, begin, count / 2);
  build(2 * i + 1, begin + count / 2, count - count / 2);
}

/// Of the points that are left.
void PointTree::rebuild(std::size_t i) {
  const Node& node = nodes_[i];
  const auto first = order_.begin() + static_cast<std::ptrdiff_t>(node.begin);
  std::partition(first, first + static_cast<std::ptrdiff_t>(node.count),
                 [&](std::uint32_t point) { return place_of_[point] != 0; });
  build(i, node.begin, node.left);
}

/// Along the principal axis of the points.
void PointTree::bound(Node& node) const {
  const std::span<const std::uint32_t> chosen = std::span(order_).subspan(node.begin, node.count);
  Vec2 mean;
  const double share = 1 / static_cast<double>(chosen.size());
  for (const std::uint32_t point : chosen)
    mean = {mean.x + share * points_[point].x, mean.y + share * points_[point].y};
  double xx_less_yy = 0, xy = 0;
  for (const std::uint32_t point : chosen) {
    const Vec2 off{points_[point].x - mean.x, points_[point].y - mean.y};
    xx_less_yy += off.x * off.x - off.y * off.y;
    xy += off.x * off.y;
  }
  const double angle = std::atan2(2 * xy, xx_less_yy) / 2;
  const std::array<Vec2, 2> axes{Vec2{std::cos(angle), std::sin(angle)}, {-std::sin(angle), std::cos(angle)}};
  std::array<double, 2> middle{}, half{};
  for (std::size_t k = 0; k < 2; ++k) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::uint32_t point : chosen) {
      low = std::min(low, dot(axes[k], points_[point]));
      high = std::max(high, dot(axes[k], points_[point]));
    }
    middle[k] = (low + high) / 2;
    half[k] = (high - low) / 2 + margin_;
  }
  node.centre = {middle[0] * axes[0].x + middle[1] * axes[1].x,
                 middle[0] * axes[0].y + middle[1] * axes[1].y};
  node.along = {half[0] * axes[0].x, half[0] * axes[0].y};
  node.across = {half[1] * axes[1].x, half[1] * axes[1].y};
}

/// False where an edge of either has the other beyond it.
bool PointTree::meets(const Node& box, const Triangle2& triangle) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 a = triangle[k], b = triangle[(k + 1) % 3];
    const Vec2 inwards{a.y - b.y, b.x - a.x};
    const double at_centre = dot(inwards, {box.centre.x - a.x, box.centre.y - a.y});
    if (at_centre + std::abs(dot(inwards, box.along)) + std::abs(dot(inwards, box.across)) < 0) return false;
  }
  for (const Vec2 axis : {box.along, box.across}) {
    std::array<double, 3> places{};
    for (std::size_t k = 0; k < 3; ++k)
      places[k] = dot(axis, {triangle[k].x - box.centre.x, triangle[k].y - box.centre.y});
    const auto [low, high] = std::minmax({places[0], places[1], places[2]});
    if (low > dot(axis, axis) || high < -dot(axis, axis)) return false;
  }
  return true;
}

/// A node that has lost many is built anew, as its box may be smaller then.
void PointTree::remove(std::uint32_t point) {
  const std::size_t place = place_of_[point];
  place_of_[point] = 0;
  std::size_t sparse = 0;
  for (std::size_t i = place; i > 0; i /= 2) {
    const Node& node = nodes_[i];
    if (--nodes_[i].left > 0 && 2 * node.left <= node.count) sparse = i;
  }
  if (sparse > 0) rebuild(sparse);
}

}  // namespace stbvh::harness
