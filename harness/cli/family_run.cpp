#include "harness/cli/family_run.h"

#include <fmt/format.h>

#include <map>
#include <new>

#include "harness/cli/distance_figures.h"
#include "harness/hard_cases/judged_case.h"
#include "harness/program/session.h"
#include "harness/program/trace.h"

namespace stbvh::harness {
namespace {

HardResult to_result(const std::string& family, const std::string& structure, bool is_closed,
                     const HardCounts& counts) {
  const ErrorCounts& errors = counts.errors;
  return {.family = family,
          .structure = structure,
          .traced = errors.traced,
          .oracle_hits = errors.oracle_hits,
          .leaks = is_closed ? std::optional(counts.leaks) : std::nullopt,
          .missed = errors.missed,
          .false_hits = errors.false_hits,
          .wrong_primitive = errors.wrong_primitive,
          .near_misses = counts.near_misses,
          .any_hit_wrong = counts.any_wrong,
          .self_hits = counts.departures > 0 ? std::optional(counts.self_hits) : std::nullopt,
          .exact_self_hits = counts.departures > 0 ? std::optional(counts.exact_self_hits) : std::nullopt,
          .ties = errors.ties,
          .within_rounding = errors.within_rounding,
          .near_edge = errors.near_edge,
          .distance = distance_figures(errors.distances)};
}

/// All cases of one family.
class FamilyRun {
 public:
  FamilyRun(const HardFamily& family, const std::vector<std::string>& structures, PinnedThreads& threads,
            Progress& progress)
      : family_(family), structures_(structures), threads_(threads), progress_(progress) {}

  std::vector<HardResult> run(std::size_t count, std::uint64_t seed) {
    stage("making the cases");
    for (const HardCase& hard : family_.make(count, seed)) {
      is_closed_ |= hard.expected == Expected::kClosed;
      run_case(hard);
    }
    std::vector<HardResult> results;
    for (const std::string& name : structures_) {
      if (!counts_.contains(name)) continue;
      finish(counts_[name]);
      results.push_back(to_result(family_.name, name, is_closed_, counts_[name]));
    }
    return results;
  }

  /// A wrong answer of each structure of ours that gave one.
  std::string examples() const {
    std::string text;
    for (const auto& [name, counts] : counts_) {
      if (is_exact(name) && !counts.example.empty()) {
        text += fmt::format("  {}, {}\n", name, counts.example);
      }
    }
    return text;
  }

 private:
  void stage(std::string_view what) { progress_.stage(fmt::format("{}: {}", family_.name, what)); }

  void run_case(const HardCase& hard) {
    stage("asking the oracle");
    const JudgedCase judged(hard);
    for (const std::string& name : structures_that_fit(structures_, hard.scene, "")) {
      if (!family_.admits(name)) continue;
      stage(fmt::format("building {}", name));
      if (judged.must_be_refused()) {
        judged.judge_refusal(refusal(name, hard.scene), counts_[name]);
      } else {
        trace_case(judged, *build_structure(name, hard.scene, threads_.count()), name);
      }
    }
  }

  /// The error that building ends with; empty if there is none.
  std::string refusal(const std::string& name, const Scene& scene) const {
    try {
      build_structure(name, scene, threads_.count());
      return "";
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& e) {
      return e.what();
    }
  }

  void trace_case(const JudgedCase& judged, const StructureUnderTest& structure, const std::string& name) {
    for (std::size_t batch = 0; batch < judged.batch_count(); ++batch) {
      stage(fmt::format("tracing {}, {} of {}", name, batch + 1, judged.batch_count()));
      std::vector<HitRecord> closest(judged.closest(batch).rays.size());
      std::vector<HitRecord> any(closest.size());
      trace(threads_, structure, judged.closest(batch), closest);
      trace(threads_, structure, judged.any(batch), any);
      judged.judge_batch(batch, closest, any, counts_[name]);
    }
  }

  const HardFamily& family_;
  const std::vector<std::string>& structures_;
  PinnedThreads& threads_;
  Progress& progress_;
  bool is_closed_ = false;
  std::map<std::string, HardCounts> counts_;
};

}  // namespace

FamilyResults run_family(const HardFamily& family, std::size_t count, std::uint64_t seed,
                         const std::vector<std::string>& structures, PinnedThreads& threads,
                         Progress& progress) {
  FamilyRun run(family, structures, threads, progress);
  FamilyResults found;
  found.results = run.run(count, seed);
  found.examples = run.examples();
  return found;
}

}  // namespace stbvh::harness
