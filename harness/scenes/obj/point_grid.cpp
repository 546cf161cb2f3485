#include "harness/scenes/obj/point_grid.h"

#include <cmath>
#include <limits>
#include <numeric>

namespace stbvh::harness {
namespace {

constexpr std::size_t kLargestSide = 2048;

std::size_t side_for(std::size_t points) {
  const auto root = static_cast<std::size_t>(std::sqrt(static_cast<double>(points)));
  return std::clamp<std::size_t>(root, 1, kLargestSide);
}

}  // namespace

PointGrid::PointGrid(const Polygon& points)
    : side_(side_for(points.size())), lowest_(points[0]), points_(points.size()), place_of_(points.size()) {
  Vec2 highest = points[0];
  for (const Vec2& p : points) {
    lowest_ = {std::min(lowest_.x, p.x), std::min(lowest_.y, p.y)};
    highest = {std::max(highest.x, p.x), std::max(highest.y, p.y)};
  }
  const auto cell_length = [&](double extent) {
    return extent > 0 ? extent / static_cast<double>(side_) : 1;
  };
  cell_ = {cell_length(highest.x - lowest_.x), cell_length(highest.y - lowest_.y)};
  for (const Vec2& p : points) cell_of_.push_back(row_of(p.y) * side_ + column_of(p.x));
  std::iota(points_.begin(), points_.end(), 0);
  std::stable_sort(points_.begin(), points_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return cell_of_[a] < cell_of_[b]; });
  begin_.assign(side_ * side_, 0);
  end_.assign(side_ * side_, 0);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const std::size_t cell = cell_of_[points_[i]];
    if (end_[cell] == 0) begin_[cell] = i;
    end_[cell] = i + 1;
    place_of_[points_[i]] = i;
  }
}

void PointGrid::remove(std::uint32_t point) {
  const std::size_t hole = place_of_[point], last = --end_[cell_of_[point]];
  points_[hole] = points_[last];
  place_of_[points_[hole]] = hole;
}

std::size_t PointGrid::place(double cells) const {
  return static_cast<std::size_t>(std::clamp(cells, 0.0, static_cast<double>(side_ - 1)));
}

std::pair<std::size_t, std::size_t> PointGrid::columns(const Triangle2& triangle, std::size_t row) const {
  constexpr double kMargin = 1e-6;  // of a cell: more than all rounding here
  const double low = lowest_.y + cell_.y * (static_cast<double>(row) - kMargin);
  const double high = row + 1 == side_ ? std::numeric_limits<double>::infinity()
                                       : lowest_.y + cell_.y * (static_cast<double>(row + 1) + kMargin);
  double left = std::numeric_limits<double>::infinity(), right = -left;
  for (std::size_t k = 0; k < 3; ++k) {
    Vec2 a = triangle[k], b = triangle[(k + 1) % 3];
    if (a.y > b.y) std::swap(a, b);
    if (b.y < low || a.y > high) continue;
    const auto x_at = [&](double y) { return a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)); };
    const double from = a.y < low ? x_at(low) : a.x, to = b.y > high ? x_at(high) : b.x;
    left = std::min({left, from, to});
    right = std::max({right, from, to});
  }
  return {column_of(left - kMargin * cell_.x), column_of(right + kMargin * cell_.x)};
}

}  // namespace stbvh::harness
