#include "harness/cli/wrong_answers.h"

#include <fmt/format.h>

#include <cstddef>
#include <string>

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
void require_right_answers(std::span<const ErrorResult> results) {
  std::size_t total = 0;
  std::string where;
  for (const ErrorResult& r : results) {
    const std::size_t wrong = r.missed + r.false_hits + r.wrong_primitive;
    if (!is_exact(r.structure) || wrong == 0) continue;
    total += wrong;
    where += fmt::format("{}{} on {}, {}: {} missed, {} false, {} wrong primitive", where.empty() ? "" : "; ",
                         r.structure, r.scene, r.rays, r.missed, r.false_hits, r.wrong_primitive);
  }
  if (total > 0) throw WrongAnswers(fmt::format("{} wrong answers of our structures ({}).", total, where));
}

void require_right_answers(std::span<const HardResult> results) {
  std::size_t total = 0;
  std::string where;
  for (const HardResult& r : results) {
    const std::size_t leaks = r.leaks.value_or(0);
    const std::size_t wrong = leaks + r.missed + r.false_hits + r.wrong_primitive + r.any_hit_wrong;
    if (!is_exact(r.structure) || wrong == 0) continue;
    total += wrong;
    where += fmt::format("{}{} on {}: {} leaks, {} missed, {} false, {} wrong primitive, {} any hit",
                         where.empty() ? "" : "; ", r.structure, r.family, leaks, r.missed, r.false_hits,
                         r.wrong_primitive, r.any_hit_wrong);
  }
  if (total > 0) throw WrongAnswers(fmt::format("{} wrong answers of our structures ({}).", total, where));
}

}  // namespace stbvh::harness
