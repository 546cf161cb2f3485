#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "harness/report/distinct.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kReferencesAbreast = 2;
constexpr int kStructureWidth = 21;
constexpr int kMeanWidth = 16;
constexpr int kSceneWidth = 33;  // of a ratio, its spread and the scene's name

using Summaries = std::vector<SummaryResult>;

Summaries select(const Summaries& results, const auto& is_wanted) {
  Summaries wanted;
  std::copy_if(results.begin(), results.end(), std::back_inserter(wanted), is_wanted);
  return wanted;
}

/// Null for what is not there, and for a structure against itself.
const SummaryResult* find(const Summaries& results, const std::string& structure,
                          const std::string& reference) {
  const auto found = std::find_if(results.begin(), results.end(), [&](const SummaryResult& r) {
    return r.structure == structure && r.reference == reference;
  });
  return found == results.end() || structure == reference ? nullptr : &*found;
}

/// Without the spaces that fill the last column.
void end_line(std::string& text) {
  text.erase(text.find_last_not_of(' ') + 1);
  text += "\n";
}

std::string with_spread(const Spread& s) {
  return fmt::format("{:.2f} {:.2f}-{:.2f}", s.median, s.min, s.max);
}

/// Which structures are not in all scenes of the run.
std::string gaps(const Summaries& results) {
  std::size_t most = 0;
  for (const SummaryResult& r : results) most = std::max(most, r.scenes);
  std::string text;
  for (const SummaryResult& r : results) {
    if (r.scenes < most)
      text += fmt::format("{} against {}: {} of {} scenes\n", r.structure, r.reference, r.scenes, most);
  }
  return text;
}

/// Speeds of one thread count and kind of rays against a few references side by side.
std::string speed_block(const Summaries& results, std::span<const std::string> references) {
  std::string text = fmt::format("{:<{}}", "structure", kStructureWidth);
  for (const std::string& reference : references)
    text += fmt::format("{:>{}}  {:<{}}", "to " + reference, kMeanWidth - 1, "worst scene", kSceneWidth - 1);
  end_line(text);
  for (const std::string& structure : distinct(results, &SummaryResult::structure)) {
    text += fmt::format("{:<{}}", structure, kStructureWidth);
    for (const std::string& reference : references) {
      const SummaryResult* r = find(results, structure, reference);
      text += fmt::format("{:>{}}  {:<{}}", r == nullptr ? "-" : with_spread(r->mean), kMeanWidth - 1,
                          r == nullptr ? "-" : with_spread(r->worst) + " " + r->worst_scene, kSceneWidth - 1);
    }
    end_line(text);
  }
  return text;
}

std::string speed_blocks(const Summaries& results) {
  const SummaryResult& any = results.front();
  std::string text = fmt::format(
      "\nspeed, {}, {} threads: geometric mean of the ratios, its least and largest in a repeat\n", any.rays,
      any.threads);
  const auto references = distinct(results, &SummaryResult::reference);
  for (std::size_t first = 0; first < references.size(); first += kReferencesAbreast) {
    const std::size_t count = std::min(kReferencesAbreast, references.size() - first);
    text += speed_block(results, std::span(references).subspan(first, count));
  }
  return text + gaps(results);
}

struct BuildColumn {
  const char* measure;
  const char* heading;
};
constexpr BuildColumn kBuildColumns[] = {
    {"structure_bytes", "bytes"}, {"total_bytes", "with buffers"}, {"build_s", "build time"}};

/// Bytes and build time against one reference.
std::string build_block(const Summaries& results, const std::string& reference) {
  std::string text = fmt::format("{:<{}}", "to " + reference, kStructureWidth);
  for (const BuildColumn& column : kBuildColumns)
    text += fmt::format("{:>13}  {:<21}", column.heading, "worst scene");
  end_line(text);
  for (const std::string& structure : distinct(results, &SummaryResult::structure)) {
    text += fmt::format("{:<{}}", structure, kStructureWidth);
    for (const BuildColumn& column : kBuildColumns) {
      const Summaries of_measure =
          select(results, [&](const SummaryResult& r) { return r.measure == column.measure; });
      const SummaryResult* r = find(of_measure, structure, reference);
      text += fmt::format("{:>13}  {:<21}", r == nullptr ? "-" : fmt::format("{:.2f}", r->mean.median),
                          r == nullptr ? "-" : fmt::format("{:.2f} {}", r->worst.median, r->worst_scene));
    }
    end_line(text);
  }
  return text;
}

}  // namespace

std::string summary_table(const std::vector<SummaryResult>& results) {
  if (results.empty()) return "";
  std::size_t scenes = 0;
  for (const SummaryResult& r : results) scenes = std::max(scenes, r.scenes);
  std::string text = fmt::format("\n== all {} scenes\n", scenes);
  const Summaries speeds = select(results, [](const SummaryResult& r) { return r.measure == "speed"; });
  for (unsigned threads : distinct(speeds, &SummaryResult::threads)) {
    for (const std::string& rays : distinct(speeds, &SummaryResult::rays)) {
      text += speed_blocks(
          select(speeds, [&](const SummaryResult& r) { return r.threads == threads && r.rays == rays; }));
    }
  }
  const Summaries builds = select(results, [](const SummaryResult& r) { return r.measure != "speed"; });
  if (builds.empty()) return text;
  text += fmt::format("\nbytes and build time, {} threads: geometric means of the ratios\n",
                      builds.front().threads);
  for (const std::string& reference : distinct(builds, &SummaryResult::reference))
    text += build_block(builds, reference);
  return text + gaps(select(builds, [](const SummaryResult& r) { return r.measure == "structure_bytes"; }));
}

}  // namespace stbvh::harness
