#include "harness/report/gallery_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "harness/report/distinct.h"

namespace stbvh::harness {
namespace {

/// Bytes and build time are held against those of this one, whatever the speed is held against.
constexpr std::string_view kReference = "stbvh-direct";
constexpr std::string_view kAllRays = "bounce+uniform+shadow";
constexpr std::array<std::string_view, 4> kRays{"bounce", "uniform", "shadow", "primary"};

/// One structure over all scenes.
class Row {
 public:
  Row(const std::string& structure, const std::vector<GalleryResult>& results,
      const std::vector<SummaryResult>& summaries)
      : structure_(structure), summaries_(summaries) {
    for (const GalleryResult& r : results) {
      if (r.structure == structure) results_.push_back(&r);
    }
  }

  std::string text(std::size_t scenes) const {
    const GalleryResult& any = *results_.front();
    const bool is_scalar = any.compared_with != kReference;
    std::string line = fmt::format("{:<27}", structure_ + (is_scalar ? " *" : ""));
    for (const std::string_view rays : kRays) line += fmt::format("{:>8}", mean(speed(rays)));
    const SummaryResult* all = speed(kAllRays);
    line += fmt::format("{:>18}", all == nullptr ? "-"
                                                 : fmt::format("{:.2f} ({:.2f}-{:.2f})", all->mean.median,
                                                               all->mean.min, all->mean.max));
    line += fmt::format("{:>7}{:>7}", visits(&GalleryResult::Visits::nodes),
                        visits(&GalleryResult::Visits::leaves));
    line += fmt::format("{:>7}{:>7}{:>9}  {:<9}", mean(build("structure_bytes")), mean(build("build_s")),
                        wrong(), any.steps);
    const auto measured = std::ranges::count_if(results_, [](const auto* r) { return r->traced > 0; });
    if (static_cast<std::size_t>(measured) < scenes)
      line += fmt::format("  {} of {} scenes", measured, scenes);
    return line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }

 private:
  const SummaryResult* find(std::string_view measure, std::string_view rays,
                            std::string_view reference) const {
    const auto found = std::ranges::find_if(summaries_, [&](const SummaryResult& r) {
      return r.structure == structure_ && r.measure == measure && r.rays == rays && r.reference == reference;
    });
    return found == summaries_.end() ? nullptr : &*found;
  }
  const SummaryResult* speed(std::string_view rays) const {
    return find("speed", rays, results_.front()->compared_with);
  }
  const SummaryResult* build(std::string_view measure) const { return find(measure, "", kReference); }

  static std::string mean(const SummaryResult* r) {
    return r == nullptr ? "-" : fmt::format("{:.2f}", r->mean.median);
  }

  /// Geometric mean over the scenes.
  std::string visits(double GalleryResult::Visits::*part) const {
    std::vector<double> values;
    for (const GalleryResult* r : results_) {
      if (r->visits && (*r->visits).*part > 0) values.push_back((*r->visits).*part);
    }
    return values.empty() ? "-" : fmt::format("{:.1f}", geometric_mean(values));
  }

  std::string wrong() const {
    std::size_t traced = 0, wrong = 0;
    for (const GalleryResult* r : results_) traced += r->traced, wrong += r->wrong;
    if (traced == 0) return "-";
    if (wrong == 0) return "0";
    if (results_.front()->is_exact) return fmt::format("{} !", wrong);
    return fmt::format("{:.2g} %", 100 * static_cast<double>(wrong) / static_cast<double>(traced));
  }

  const std::string& structure_;
  const std::vector<SummaryResult>& summaries_;
  std::vector<const GalleryResult*> results_;
};

/// A sentence for each structure and reason, with the scenes.
std::string obstacles(const std::vector<GalleryResult>& results) {
  std::string text;
  for (const std::string& structure : distinct(results, &GalleryResult::structure)) {
    std::vector<GalleryResult> left_out;
    for (const GalleryResult& r : results) {
      if (r.structure == structure && !r.obstacle.empty()) left_out.push_back(r);
    }
    for (const std::string& why : distinct(left_out, &GalleryResult::obstacle)) {
      std::string scenes;
      for (const GalleryResult& r : left_out) {
        if (r.obstacle == why) scenes += (scenes.empty() ? "" : ", ") + r.scene;
      }
      text += fmt::format("{} does not take {}: {}.\n", structure, scenes, why);
    }
  }
  return text;
}

}  // namespace

std::string gallery_table(const std::vector<GalleryResult>& results,
                          const std::vector<SummaryResult>& summaries) {
  if (results.empty()) return "";
  const std::size_t scenes = distinct(results, &GalleryResult::scene).size();
  std::string text = fmt::format("\nthe gallery, {} scene{}: speed, bytes and build time of {} = 1\n{:<27}",
                                 scenes, scenes == 1 ? "" : "s", kReference, "structure");
  for (const std::string_view rays : kRays) text += fmt::format("{:>8}", rays);
  text += fmt::format("{:>18}{:>7}{:>7}{:>7}{:>7}{:>9}  {}\n", "all (spread)", "nodes", "leaves", "bytes",
                      "build", "wrong", "steps");
  for (const std::string& structure : distinct(results, &GalleryResult::structure))
    text += Row(structure, results, summaries).text(scenes);
  return text + obstacles(results) +
         "*: without vector instructions, speed of stbvh-direct-scalar = 1. all: bounce, uniform and shadow "
         "rays; spread: of\nthe mean, in the repeats. nodes, leaves: of a bounce or uniform ray. wrong: "
         "answers "
         "beyond rounding, !: of a method\nthat promises none. steps: that a mesh may have.\n";
}

}  // namespace stbvh::harness
