#include "harness/scenes/obj/ear_clipper.h"

#include <array>

namespace stbvh::harness {
namespace {

bool is_same(Vec2 a, Vec2 b) {
  return a.x == b.x && a.y == b.y;
}

bool is_in_closed(const Triangle2& t, Vec2 p) {
  return doubled_area(t[0], t[1], p) >= 0 && doubled_area(t[1], t[2], p) >= 0 &&
         doubled_area(t[2], t[0], p) >= 0;
}

/// Whether an edge from corner `k` of the triangle to `p` begins inside it.
bool leads_inside(const Triangle2& t, std::size_t k, Vec2 p) {
  return doubled_area(t[k], t[(k + 1) % 3], p) > 0 && doubled_area(t[(k + 2) % 3], t[k], p) > 0;
}

}  // namespace

EarClipper::EarClipper(const Polygon& polygon)
    : points_(polygon), grid_(polygon), is_candidate_(polygon.size(), false) {
  const auto count = static_cast<std::uint32_t>(polygon.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    previous_.push_back((i + count - 1) % count);
    next_.push_back((i + 1) % count);
  }
}

void EarClipper::ask(std::uint32_t corner) {
  if (is_candidate_[corner]) return;
  is_candidate_[corner] = true;
  candidates_.push_back(corner);
}

void EarClipper::ask_all(std::uint32_t first) {
  ask(first);
  for (std::uint32_t corner = next_[first]; corner != first; corner = next_[corner]) ask(corner);
}

void EarClipper::cut(std::vector<std::uint32_t>& triangles) {
  Rule rule = Rule::kEars;
  std::uint32_t some = 0;  // corner that is left
  bool has_clipped = true;
  std::size_t left = points_.size();
  while (left >= 3) {
    if (candidates_.empty()) {
      if (!has_clipped) rule = rule == Rule::kEars ? Rule::kNotInverted : Rule::kAnything;
      has_clipped = false;
      ask_all(some);
    }
    const std::uint32_t corner = candidates_.front();
    candidates_.pop_front();
    is_candidate_[corner] = false;
    if (left > 3 && !may_clip(corner, rule)) continue;
    triangles.insert(triangles.end(), {previous_[corner], corner, next_[corner]});
    some = next_[corner];
    clip(corner);
    has_clipped = true;
    --left;
  }
}

bool EarClipper::may_clip(std::uint32_t corner, Rule rule) const {
  if (rule == Rule::kEars) return is_ear(corner);
  return rule == Rule::kAnything ||
         doubled_area(points_[previous_[corner]], points_[corner], points_[next_[corner]]) >= 0;
}

/// Whether the triangle of a corner and its neighbours is inside the polygon.
bool EarClipper::is_ear(std::uint32_t corner) const {
  const std::array<std::uint32_t, 3> corners{previous_[corner], corner, next_[corner]};
  const Triangle2 t{points_[corners[0]], points_[corners[1]], points_[corners[2]]};
  if (!(doubled_area(t[0], t[1], t[2]) > 0)) return false;
  return !grid_.any_near(t, [&](std::uint32_t other) {
    if (other == corners[0] || other == corners[1] || other == corners[2]) return false;
    if (!is_in_closed(t, points_[other])) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (is_same(points_[other], t[k]))
        return leads_inside(t, k, points_[previous_[other]]) || leads_inside(t, k, points_[next_[other]]);
    }
    return true;
  });
}

void EarClipper::clip(std::uint32_t corner) {
  const std::uint32_t before = previous_[corner], after = next_[corner];
  next_[before] = after;
  previous_[after] = before;
  grid_.remove(corner);
  ask(before);
  ask(after);
}

}  // namespace stbvh::harness
