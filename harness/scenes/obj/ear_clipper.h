/// Triangles of a polygon, by ear clipping.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "harness/scenes/obj/point_tree.h"

namespace stbvh::harness {

/// Clips ears, corner by corner round and round, so that they are as small as they may be.
class EarClipper {
 public:
  /// `polygon`: wound counterclockwise, of 3 corners or more.
  explicit EarClipper(const Polygon& polygon);

  /// Appends the triangles, three corners each, two fewer than there are corners. They cover the polygon once
  /// where it is simple but for corners where it folds back onto itself.
  void cut(std::vector<std::uint32_t>& triangles);

 private:
  /// What is clipped; the next where none is left. There is always an ear but in polygons that cross
  /// themselves or have no area.
  enum class Rule { kFolds, kEars, kNotInverted, kAnything };

  void clip_all(Rule rule, std::vector<std::uint32_t>& triangles);
  bool may_clip(std::uint32_t corner, Rule rule) const;
  double doubled_area_at(std::uint32_t corner) const;
  bool is_fold(std::uint32_t corner) const;
  bool ends_slit(std::uint32_t fold) const;
  bool is_ear(std::uint32_t corner) const;
  void find_reflex();
  void clip(std::uint32_t corner);
  void ask(std::uint32_t corner);
  void ask_all();

  const Polygon& points_;
  std::vector<std::uint32_t> previous_, next_;  ///< of the corners that are left
  std::size_t left_;                            ///< how many these are
  std::uint32_t some_ = 0;                      ///< of these
  std::optional<PointTree> reflex_;             ///< of these, those that may be in the triangle of another
  std::vector<bool> ends_slit_;                 ///< of all corners
  std::deque<std::uint32_t> candidates_;
  std::vector<bool> is_candidate_;
};

}  // namespace stbvh::harness
