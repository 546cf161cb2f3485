/// Triangles of a polygon, by ear clipping.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "harness/scenes/obj/point_grid.h"

namespace stbvh::harness {

/// Clips ears, corner by corner round and round, so that they are as small as they may be.
class EarClipper {
 public:
  /// `polygon`: wound counterclockwise, of 3 corners or more.
  explicit EarClipper(const Polygon& polygon);

  /// Appends the triangles, three corners each, two fewer than there are corners. They cover the polygon once
  /// where it is simple.
  void cut(std::vector<std::uint32_t>& triangles);

 private:
  /// What is clipped; the next where no ear is left, as there always is one but in polygons that cross
  /// themselves or have no area.
  enum class Rule { kEars, kNotInverted, kAnything };

  bool may_clip(std::uint32_t corner, Rule rule) const;
  bool is_ear(std::uint32_t corner) const;
  void clip(std::uint32_t corner);
  void ask(std::uint32_t corner);
  void ask_all(std::uint32_t first);

  const Polygon& points_;
  std::vector<std::uint32_t> previous_, next_;  ///< of the corners that are left
  PointGrid grid_;                              ///< of these
  std::deque<std::uint32_t> candidates_;
  std::vector<bool> is_candidate_;
};

}  // namespace stbvh::harness
