#include "harness/report/summary.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "harness/report/distinct.h"

namespace stbvh::harness {
namespace {

using Names = std::vector<std::string>;

constexpr std::array<std::string_view, 4> kReferences{"embree", "embree-4v", "lbvh", "lbvh-4v"};
/// What incoherent light transport traces, for one figure over all of it.
const Names kTogether{"bounce", "uniform", "shadow"};

/// A structure's ratio to a reference in one scene, in each repeat.
struct SceneRatios {
  std::string scene;
  std::vector<double> ratios;
};

enum class Worst { kLeast, kLargest };

/// The figures of `result` that come from ratios of at least one scene.
SummaryResult over_scenes(SummaryResult result, const std::vector<SceneRatios>& scenes, Worst worst) {
  std::size_t repeats = scenes.front().ratios.size();
  for (const SceneRatios& s : scenes) repeats = std::min(repeats, s.ratios.size());
  std::vector<double> means;
  for (std::size_t r = 0; r < repeats; ++r) {
    std::vector<double> ratios;
    for (const SceneRatios& s : scenes) ratios.push_back(s.ratios[r]);
    means.push_back(geometric_mean(ratios));
  }
  result.scenes = scenes.size();
  result.mean = spread_of(means);
  for (const SceneRatios& s : scenes) {
    const Spread spread = spread_of(s.ratios);
    const bool is_worse =
        worst == Worst::kLeast ? spread.median < result.worst.median : spread.median > result.worst.median;
    if (result.worst_scene.empty() || is_worse) {
      result.worst_scene = s.scene;
      result.worst = spread;
    }
  }
  return result;
}

std::string joined(const Names& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : "+") + name;
  return text;
}

/// Summaries of one report.
class Summary {
 public:
  Summary(const Report& report, std::span<const std::string_view> references)
      : report_(report),
        scenes_(distinct(report.builds, &BuildResult::scene)),
        structures_(distinct(report.builds, &BuildResult::structure)) {
    for (std::string_view name : references) {
      if (std::find(structures_.begin(), structures_.end(), name) != structures_.end())
        references_.emplace_back(name);
    }
  }

  std::vector<SummaryResult> results() {
    for (unsigned threads : distinct(report_.speeds, &SpeedResult::threads)) {
      for (const Names& kinds : kinds_of_rays()) add_speeds(threads, kinds);
    }
    const auto count = [](std::size_t bytes) { return static_cast<double>(bytes); };
    add_builds("structure_bytes", [&](const BuildResult& b) { return count(b.structure_bytes); });
    add_builds("total_bytes", [&](const BuildResult& b) { return count(b.total_bytes); });
    add_builds("build_s", [](const BuildResult& b) { return b.build_s.median; });
    return std::move(results_);
  }

 private:
  /// Each kind, then those that count together.
  std::vector<Names> kinds_of_rays() const {
    const Names kinds = distinct(report_.speeds, &SpeedResult::rays);
    std::vector<Names> sets;
    for (const std::string& kind : kinds) sets.push_back({kind});
    const auto is_traced = [&](const std::string& kind) {
      return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
    };
    if (std::all_of(kTogether.begin(), kTogether.end(), is_traced)) sets.push_back(kTogether);
    return sets;
  }

  const SpeedResult* speed(const std::string& scene, const std::string& structure, const std::string& rays,
                           unsigned threads) const {
    for (const SpeedResult& s : report_.speeds) {
      if (s.scene == scene && s.structure == structure && s.rays == rays && s.threads == threads) return &s;
    }
    return nullptr;
  }

  const BuildResult* build(const std::string& scene, const std::string& structure) const {
    for (const BuildResult& b : report_.builds) {
      if (b.scene == scene && b.structure == structure) return &b;
    }
    return nullptr;
  }

  /// Geometric mean over the kinds in each repeat, by way of embree, which every structure was traced
  /// against.
  std::optional<SceneRatios> speed_ratios(const std::string& scene, const std::string& structure,
                                          const std::string& reference, unsigned threads,
                                          const Names& kinds) const {
    std::vector<std::vector<double>> of_repeat;
    for (const std::string& kind : kinds) {
      const SpeedResult* s = speed(scene, structure, kind, threads);
      const SpeedResult* r = speed(scene, reference, kind, threads);
      if (s == nullptr || r == nullptr) return std::nullopt;
      const std::size_t repeats = std::min(s->ratios_to_embree.size(), r->ratios_to_embree.size());
      if (repeats == 0) return std::nullopt;
      of_repeat.resize(of_repeat.empty() ? repeats : std::min(of_repeat.size(), repeats));
      for (std::size_t i = 0; i < of_repeat.size(); ++i)
        of_repeat[i].push_back(s->ratios_to_embree[i] / r->ratios_to_embree[i]);
    }
    SceneRatios ratios{scene, {}};
    for (const std::vector<double>& values : of_repeat) ratios.ratios.push_back(geometric_mean(values));
    return ratios;
  }

  void add_speeds(unsigned threads, const Names& kinds) {
    for (const std::string& structure : structures_) {
      for (const std::string& reference : references_) {
        std::vector<SceneRatios> scenes;
        for (const std::string& scene : scenes_) {
          if (auto ratios = speed_ratios(scene, structure, reference, threads, kinds))
            scenes.push_back(std::move(*ratios));
        }
        if (scenes.empty()) continue;
        results_.push_back(over_scenes({.structure = structure,
                                        .reference = reference,
                                        .measure = "speed",
                                        .rays = joined(kinds),
                                        .threads = threads},
                                       scenes, Worst::kLeast));
      }
    }
  }

  template <class Value>
  void add_builds(const std::string& measure, const Value& value) {
    for (const std::string& structure : structures_) {
      for (const std::string& reference : references_) {
        std::vector<SceneRatios> scenes;
        for (const std::string& scene : scenes_) {
          const BuildResult* s = build(scene, structure);
          const BuildResult* r = build(scene, reference);
          if (s != nullptr && r != nullptr && value(*r) > 0)
            scenes.push_back({scene, {value(*s) / value(*r)}});
        }
        if (scenes.empty()) continue;
        results_.push_back(over_scenes({.structure = structure,
                                        .reference = reference,
                                        .measure = measure,
                                        .rays = "",
                                        .threads = report_.builds.front().threads},
                                       scenes, Worst::kLargest));
      }
    }
  }

  const Report& report_;
  Names scenes_;
  Names structures_;
  Names references_;
  std::vector<SummaryResult> results_;
};

}  // namespace

std::vector<SummaryResult> summarize_scenes(const Report& report) {
  if (distinct(report.builds, &BuildResult::scene).size() < 2) return {};
  return summarize_scenes(report, kReferences);
}

std::vector<SummaryResult> summarize_scenes(const Report& report,
                                            std::span<const std::string_view> references) {
  return Summary(report, references).results();
}

}  // namespace stbvh::harness
