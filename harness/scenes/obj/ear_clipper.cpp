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
    : points_(polygon), left_(polygon.size()), is_candidate_(polygon.size(), false) {
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

void EarClipper::ask_all() {
  ask(some_);
  for (std::uint32_t corner = next_[some_]; corner != some_; corner = next_[corner]) ask(corner);
}

void EarClipper::cut(std::vector<std::uint32_t>& triangles) {
  for (std::uint32_t corner = 0; corner < left_; ++corner)
    ends_slit_.push_back(is_fold(corner) && ends_slit(corner));
  clip_all(Rule::kFolds, triangles);
  find_reflex();
  for (const Rule rule : {Rule::kEars, Rule::kNotInverted, Rule::kAnything}) clip_all(rule, triangles);
}

/// As long as there are any, until the last triangle.
void EarClipper::clip_all(Rule rule, std::vector<std::uint32_t>& triangles) {
  for (bool has_clipped = true; has_clipped;) {
    has_clipped = false;
    if (left_ >= 3) ask_all();
    while (left_ >= 3 && !candidates_.empty()) {
      const std::uint32_t corner = candidates_.front();
      candidates_.pop_front();
      is_candidate_[corner] = false;
      if (left_ > 3 && !may_clip(corner, rule)) continue;
      triangles.insert(triangles.end(), {previous_[corner], corner, next_[corner]});
      clip(corner);
      has_clipped = true;
    }
  }
}

double EarClipper::doubled_area_at(std::uint32_t corner) const {
  return doubled_area(points_[previous_[corner]], points_[corner], points_[next_[corner]]);
}

bool EarClipper::may_clip(std::uint32_t corner, Rule rule) const {
  switch (rule) {
    case Rule::kFolds:
      return is_fold(corner) && !ends_slit_[corner];
    case Rule::kEars:
      return is_ear(corner);
    case Rule::kNotInverted:
      return doubled_area_at(corner) >= 0;
    default:
      return true;
  }
}

/// Whether the polygon turns back there, or stays where it is: what is clipped has no area.
bool EarClipper::is_fold(std::uint32_t corner) const {
  const Vec2 before = points_[previous_[corner]], at = points_[corner], after = points_[next_[corner]];
  return doubled_area(before, at, after) == 0 &&
         (before.x - at.x) * (after.x - at.x) + (before.y - at.y) * (after.y - at.y) >= 0;
}

/// Whether a fold is the inner end of a slit: that has an inside on both sides, and may open in other steps.
bool EarClipper::ends_slit(std::uint32_t fold) const {
  std::uint32_t in = previous_[fold], out = next_[fold], above = fold;
  if (!is_same(points_[in], points_[out])) return false;
  while (!is_fold(in) && !is_fold(out) && is_same(points_[previous_[in]], points_[next_[out]])) {
    above = in;
    in = previous_[in];
    out = next_[out];
  }
  const Vec2 before = points_[previous_[in]], base = points_[in], after = points_[next_[out]];
  const bool is_left_of_in = doubled_area(before, base, points_[above]) > 0;
  const bool is_left_of_out = doubled_area(base, after, points_[above]) > 0;
  return doubled_area(before, base, after) > 0 ? is_left_of_in && is_left_of_out
                                               : is_left_of_in || is_left_of_out;
}

/// A triangle with corners of the polygon in it has one of these in it.
void EarClipper::find_reflex() {
  std::vector<std::uint32_t> corners;
  std::uint32_t corner = some_;
  for (std::size_t i = 0; i < left_; ++i, corner = next_[corner]) {
    if (!(doubled_area_at(corner) > 0)) corners.push_back(corner);
  }
  reflex_.emplace(points_, std::move(corners));
}

/// Whether the triangle of a corner and its neighbours is inside the polygon. Corners that touch its edges
/// from without are no obstacle.
bool EarClipper::is_ear(std::uint32_t corner) const {
  const std::array<std::uint32_t, 3> corners{previous_[corner], corner, next_[corner]};
  const Triangle2 t{points_[corners[0]], points_[corners[1]], points_[corners[2]]};
  if (!(doubled_area(t[0], t[1], t[2]) > 0)) return false;
  return !reflex_->any_near(t, [&](std::uint32_t other) {
    if (other == corners[0] || other == corners[1] || other == corners[2]) return false;
    if (!is_in_closed(t, points_[other])) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (is_same(points_[other], t[k]))
        return leads_inside(t, k, points_[previous_[other]]) || leads_inside(t, k, points_[next_[other]]);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      const auto side = [&](std::uint32_t p) { return doubled_area(t[k], t[k + 1], points_[p]); };
      if (side(other) == 0) return side(previous_[other]) > 0 || side(next_[other]) > 0;
    }
    return true;
  });
}

void EarClipper::clip(std::uint32_t corner) {
  const std::uint32_t before = previous_[corner], after = next_[corner];
  next_[before] = after;
  previous_[after] = before;
  --left_;
  some_ = after;
  ask(before);
  ask(after);
  if (!reflex_) return;
  for (const std::uint32_t neighbour : {before, after}) {
    if (doubled_area_at(neighbour) > 0) reflex_->remove(neighbour);
  }
}

}  // namespace stbvh::harness
