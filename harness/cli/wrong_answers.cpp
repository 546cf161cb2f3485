#include "harness/cli/wrong_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

/// Wrong answers of one structure in one place.
struct Place {
  std::size_t wrong;
  std::string text;
};

/// Throws if there are any; names the worst places, the tables have them all.
void require_none(std::vector<Place> places) {
  constexpr std::size_t kNamed = 3;
  if (places.empty()) return;
  std::ranges::stable_sort(places, std::ranges::greater(), &Place::wrong);
  std::size_t total = 0;
  std::string where;
  for (std::size_t i = 0; i < places.size(); ++i) {
    total += places[i].wrong;
    if (i < kNamed) where += (i == 0 ? "" : "; ") + places[i].text;
  }
  if (places.size() > kNamed) {
    const std::size_t more = places.size() - kNamed;
    where += fmt::format("; and in {} place{} more", more, more == 1 ? "" : "s");
  }
  throw WrongAnswers(fmt::format("{} wrong answers of our structures ({}).", total, where));
}

}  // namespace

void require_right_answers(std::span<const ErrorResult> results) {
  std::vector<Place> places;
  for (const ErrorResult& r : results) {
    const std::size_t wrong = r.missed + r.false_hits + r.wrong_primitive;
    if (!is_exact(r.structure) || r.has_tolerance || wrong == 0) continue;
    places.push_back({wrong, fmt::format("{} on {}, {}: {} missed, {} false, {} wrong primitive", r.structure,
                                         r.scene, r.rays, r.missed, r.false_hits, r.wrong_primitive)});
  }
  require_none(std::move(places));
}

void require_right_answers(std::span<const HardResult> results) {
  std::vector<Place> places;
  for (const HardResult& r : results) {
    const std::size_t leaks = r.leaks.value_or(0);
    const std::size_t wrong = leaks + r.missed + r.false_hits + r.wrong_primitive + r.any_hit_wrong;
    if (!is_exact(r.structure) || wrong == 0) continue;
    places.push_back(
        {wrong,
         fmt::format("{} on {}: {} leaks, {} missed, {} false, {} wrong primitive, {} any hit", r.structure,
                     r.family, leaks, r.missed, r.false_hits, r.wrong_primitive, r.any_hit_wrong)});
  }
  require_none(std::move(places));
}

}  // namespace stbvh::harness
