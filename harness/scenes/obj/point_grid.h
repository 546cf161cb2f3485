/// Which points are near a triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "harness/scenes/obj/plane_points.h"

namespace stbvh::harness {

using Triangle2 = std::array<Vec2, 3>;

/// Points in the cells of a grid, about as many cells as points.
class PointGrid {
 public:
  explicit PointGrid(const Polygon& points);

  void remove(std::uint32_t point);

  /// Whether one of the points that are left in the cells that the triangle meets is a `hit`.
  template <class Hit>
  bool any_near(const Triangle2& triangle, const Hit& hit) const {
    const auto [low, high] = std::minmax({triangle[0].y, triangle[1].y, triangle[2].y});
    for (std::size_t row = row_of(low), last = row_of(high); row <= last; ++row) {
      const auto [left, right] = columns(triangle, row);
      for (std::size_t cell = row * side_ + left; cell <= row * side_ + right; ++cell) {
        for (std::size_t i = begin_[cell]; i < end_[cell]; ++i) {
          if (hit(points_[i])) return true;
        }
      }
    }
    return false;
  }

 private:
  std::size_t place(double cells) const;
  std::size_t column_of(double x) const { return place((x - lowest_.x) / cell_.x); }
  std::size_t row_of(double y) const { return place((y - lowest_.y) / cell_.y); }
  /// First and last column that the triangle meets in a row.
  std::pair<std::size_t, std::size_t> columns(const Triangle2& triangle, std::size_t row) const;

  std::size_t side_;                      ///< columns, and rows
  Vec2 lowest_, cell_;                    ///< corner of the grid, width and height of a cell
  std::vector<std::uint32_t> points_;     ///< cell by cell
  std::vector<std::size_t> begin_, end_;  ///< of those that are left in each cell
  std::vector<std::size_t> place_of_;     ///< of each point in points_
  std::vector<std::size_t> cell_of_;
};

}  // namespace stbvh::harness
