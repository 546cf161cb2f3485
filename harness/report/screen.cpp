#include "harness/report/screen.h"

#include <fmt/format.h>

#include <algorithm>

#include "harness/report/distinct.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

constexpr std::string_view kReference = "embree";
constexpr std::size_t kMostKinds = 4;  // of rays, side by side

using Summaries = std::vector<SummaryResult>;

const SummaryResult* find(const Summaries& results, const std::string& structure, const std::string& measure,
                          const std::string& rays = "") {
  const auto found = std::find_if(results.begin(), results.end(), [&](const SummaryResult& r) {
    return r.structure == structure && r.measure == measure && r.rays == rays;
  });
  return found == results.end() ? nullptr : &*found;
}

std::string mean_of(const SummaryResult* r) {
  return r == nullptr ? "-" : fmt::format("{:.2f}", r->mean.median);
}

/// Speeds of one thread count, and what does not depend on it.
std::string summary_block(const Summaries& speeds, const Summaries& builds, std::size_t scenes) {
  std::vector<std::string> kinds = distinct(speeds, &SummaryResult::rays);
  const std::string all = kinds.back();  // kinds together, where there are any
  const bool is_joint = all.find('+') != std::string::npos;
  kinds.resize(std::min(kinds.size() - (is_joint ? 1 : 0), kMostKinds));
  std::string text = fmt::format("{:<21}", "structure");
  for (const std::string& kind : kinds) text += fmt::format("{:>9}", kind);
  text += fmt::format("{:>18}  {:<21}{:>7}{:>7}\n", is_joint ? "all (spread)" : all + " (spread)",
                      "worst scene", "bytes", "build");
  for (const std::string& structure : distinct(speeds, &SummaryResult::structure)) {
    text += fmt::format("{:<21}", structure);
    for (const std::string& kind : kinds)
      text += fmt::format("{:>9}", mean_of(find(speeds, structure, "speed", kind)));
    const SummaryResult* r = find(speeds, structure, "speed", all);
    text += fmt::format(
        "{:>18}  {:<21}{:>7}{:>7}{}\n",
        r == nullptr ? "-" : fmt::format("{:.2f} ({:.2f}-{:.2f})", r->mean.median, r->mean.min, r->mean.max),
        r == nullptr ? "-" : fmt::format("{:.2f} {}", r->worst.median, r->worst_scene),
        mean_of(find(builds, structure, "structure_bytes")), mean_of(find(builds, structure, "build_s")),
        r != nullptr && r->scenes < scenes ? fmt::format("  ({} of {} scenes)", r->scenes, scenes) : "");
  }
  return text;
}

std::string percent(std::size_t count, std::size_t n) {
  if (count == 0) return "0";
  return fmt::format("{} ({:.2g} %)", count, 100.0 * static_cast<double>(count) / static_cast<double>(n));
}

}  // namespace

std::string summary_screen(const std::vector<SummaryResult>& results) {
  const auto to_reference = [&](bool is_speed) {
    Summaries found;
    std::copy_if(results.begin(), results.end(), std::back_inserter(found), [&](const SummaryResult& r) {
      return r.reference == kReference && (r.measure == "speed") == is_speed;
    });
    return found;
  };
  const Summaries speeds = to_reference(true);
  const Summaries builds = to_reference(false);
  std::string text;
  for (unsigned threads : distinct(speeds, &SummaryResult::threads)) {
    Summaries chosen;
    std::copy_if(speeds.begin(), speeds.end(), std::back_inserter(chosen),
                 [&](const SummaryResult& r) { return r.threads == threads; });
    std::size_t scenes = 0;
    for (const SummaryResult& r : chosen) scenes = std::max(scenes, r.scenes);
    text +=
        fmt::format("\nspeed, bytes and build time of {} = 1: geometric means over {} scenes, {} threads\n",
                    kReference, scenes, threads);
    text += summary_block(chosen, builds, scenes);
  }
  if (!text.empty()) {
    text +=
        "speed: more is faster; bytes and build time: less is better; all: bounce, uniform and shadow rays; "
        "spread: of the mean, in the repeats.\n";
  }
  return text;
}

std::string error_screen(const std::vector<ErrorResult>& results) {
  if (results.empty()) return "";
  std::string text =
      fmt::format("\nanswers against the exact oracle, {} scenes\n{:<21}{:>9}{:>14}{:>14}{:>14}{:>10}\n",
                  distinct(results, &ErrorResult::scene).size(), "structure", "rays", "missed", "false",
                  "wrong", "t error");
  for (const std::string& structure : distinct(results, &ErrorResult::structure)) {
    ErrorResult sum;
    double t_error = 0;
    for (const ErrorResult& r : results) {
      if (r.structure != structure) continue;
      sum.traced += r.traced;
      sum.missed += r.missed;
      sum.false_hits += r.false_hits;
      sum.wrong_primitive += r.wrong_primitive;
      t_error = std::max(t_error, r.distance.relative.p99);
    }
    text += fmt::format("{:<21}{:>9}{:>14}{:>14}{:>14}{:>10.1e}\n", structure, sum.traced,
                        bad_count(sum.missed, sum.traced), bad_count(sum.false_hits, sum.traced),
                        bad_count(sum.wrong_primitive, sum.traced), t_error);
  }
  return text +
         "(<x): the rate is below x with 95 % confidence; t error: largest 99th percentile, relative.\n";
}

std::string hard_screen(const std::vector<HardResult>& results) {
  if (results.empty()) return "";
  std::string text = fmt::format(
      "\nhard cases, {} families: answers that are wrong beyond rounding\n"
      "{:<21}{:>9}{:>16}{:>16}{:>16}  {}\n",
      distinct(results, &HardResult::family).size(), "structure", "rays", "leaks", "closest hit", "any hit",
      "worst family");
  for (const std::string& structure : distinct(results, &HardResult::structure)) {
    std::size_t traced = 0, aimed = 0, leaks = 0, closest = 0, any = 0, most = 0;
    std::string worst = "-";
    for (const HardResult& r : results) {
      if (r.structure != structure) continue;
      const std::size_t wrong = r.missed + r.false_hits + r.wrong_primitive;
      traced += r.traced;
      aimed += r.leaks ? r.traced : 0;
      leaks += r.leaks.value_or(0);
      closest += wrong;
      any += r.any_hit_wrong;
      const std::size_t bad = std::max({r.leaks.value_or(0), wrong, r.any_hit_wrong});
      if (bad <= most) continue;
      most = bad;
      worst = fmt::format("{}: {} of {}", r.family, bad, r.traced);
    }
    text += fmt::format("{:<21}{:>9}{:>16}{:>16}{:>16}  {}\n", structure, traced, percent(leaks, aimed),
                        percent(closest, traced), percent(any, traced), worst);
  }
  return text + "leaks: of the rays from inside closed meshes.\n";
}

}  // namespace stbvh::harness
