#include <fmt/format.h>

#include <string>
#include <vector>

#include "harness/report/distinct.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

/// Of those records of `results` that `belongs` says.
template <typename Belongs>
std::string row(const std::string& structure, const std::string& what, const std::vector<EditResult>& results,
                const Belongs& belongs) {
  std::vector<double> commits, rebuilds, speeds;
  std::size_t traced = 0, differing = 0;
  for (const EditResult& r : results) {
    if (!belongs(r)) continue;
    commits.push_back(r.commit_s);
    if (r.rebuild_s > 0) rebuilds.push_back(r.rebuild_s);
    if (r.speed) speeds.push_back(r.speed->median);
    traced += r.traced;
    differing += r.differing;
  }
  if (commits.empty()) return "";
  const Spread commit = spread_of(commits);
  std::string text = fmt::format("{:<21}{:<10}{:>6}{:>12.2f}{:>12.2f}", structure, what, commits.size(),
                                 commit.median * 1e3, commit.max * 1e3);
  text += rebuilds.empty() ? fmt::format("{:>12}", "-")
                           : fmt::format("{:>12.2f}", spread_of(rebuilds).median * 1e3);
  if (speeds.empty()) return text + fmt::format("{:>20}{:>14}\n", "-", "-");
  const Spread speed = spread_of(speeds);
  return text + fmt::format("{:>8.2f} ({:.2f}-{:.2f}){:>14}\n", speed.median, speed.min, speed.max,
                            fmt::format("{}/{}", differing, traced));
}

}  // namespace

std::string edits_table(const std::vector<EditResult>& results) {
  std::string text = fmt::format("\n{:<21}{:<10}{:>6}{:>12}{:>12}{:>12}{:>20}{:>14}\n", "structure", "edit",
                                 "times", "commit ms", "longest", "anew ms", "speed to anew", "differ");
  for (const std::string& structure : distinct(results, &EditResult::structure)) {
    const std::vector<std::string> kinds = distinct(results, &EditResult::what);
    for (const std::string& what : kinds) {
      text += row(structure, what, results,
                  [&](const EditResult& r) { return r.structure == structure && r.what == what; });
    }
    if (kinds.size() > 1)
      text += row(structure, "all", results, [&](const EditResult& r) { return r.structure == structure; });
  }
  return text +
         "commit: median; anew: built from nothing in the same state; speed to anew: median (least and "
         "largest) of "
         "the edits after which rays were traced; differ: rays answered otherwise than by the one built "
         "anew.\n";
}

}  // namespace stbvh::harness
