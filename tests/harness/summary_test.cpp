/// Figures over all scenes of a run, on reports with answers known on paper.
#include "harness/report/summary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/report/json.h"
#include "harness/report/screen.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

SpeedResult speed(const char* scene, const char* structure, const char* rays, std::vector<double> ratios,
                  unsigned threads = 1) {
  return {.scene = scene,
          .structure = structure,
          .rays = rays,
          .ray_count = 10,
          .threads = threads,
          .repeats = ratios.size(),
          .mrays_per_s = {1, 1, 1},
          .ratios_to_embree = ratios};
}

BuildResult build(const char* scene, const char* structure, std::size_t bytes, double seconds) {
  return {.scene = scene,
          .structure = structure,
          .threads = 2,
          .build_s = {seconds, seconds, seconds},
          .structure_bytes = bytes,
          .total_bytes = bytes + 100};
}

/// Two scenes, two repeats of bounce rays; lbvh is half as fast as embree in one scene, twice in the other.
Report two_scenes() {
  Report report;
  report.builds = {build("a", "embree", 100, 1), build("a", "lbvh", 300, 2), build("a", "stbvh", 50, 1),
                   build("b", "embree", 100, 1), build("b", "lbvh", 300, 2), build("b", "stbvh", 200, 4)};
  report.speeds = {speed("a", "embree", "bounce", {1, 1}), speed("a", "lbvh", "bounce", {0.5, 0.5}),
                   speed("a", "stbvh", "bounce", {1, 4}),  speed("b", "embree", "bounce", {1, 1}),
                   speed("b", "lbvh", "bounce", {2, 2}),   speed("b", "stbvh", "bounce", {4, 9})};
  return report;
}

SummaryResult find(const std::vector<SummaryResult>& all, const std::string& structure,
                   const std::string& reference, const std::string& measure, const std::string& rays = "",
                   unsigned threads = 0) {
  for (const SummaryResult& r : all) {
    if (r.structure == structure && r.reference == reference && r.measure == measure && r.rays == rays &&
        (threads == 0 || r.threads == threads))
      return r;
  }
  ADD_FAILURE() << structure << " against " << reference << ": no " << measure << " " << rays;
  return {};
}

void expect_spread(const Spread& spread, double median, double min, double max) {
  EXPECT_NEAR(spread.median, median, 1e-12);
  EXPECT_NEAR(spread.min, min, 1e-12);
  EXPECT_NEAR(spread.max, max, 1e-12);
}

TEST(Summary, MeansAreTakenInEachRepeat) {
  const auto all = summarize_scenes(two_scenes());
  const SummaryResult to_embree = find(all, "stbvh", "embree", "speed", "bounce");
  EXPECT_EQ(to_embree.scenes, 2u);
  expect_spread(to_embree.mean, 4, 2, 6);  // sqrt(1 * 4) and sqrt(4 * 9)
  EXPECT_EQ(to_embree.worst_scene, "a");
  expect_spread(to_embree.worst, 2.5, 1, 4);
  const SummaryResult& to_lbvh = find(all, "stbvh", "lbvh", "speed", "bounce");
  expect_spread(to_lbvh.mean, 4, 2, 6);  // sqrt(2 * 2) and sqrt(8 * 4.5)
  EXPECT_EQ(to_lbvh.worst_scene, "b");
  expect_spread(to_lbvh.worst, 3.25, 2, 4.5);
}

TEST(Summary, TheWorstBytesAndTimeAreTheLargest) {
  const auto all = summarize_scenes(two_scenes());
  const SummaryResult bytes = find(all, "stbvh", "embree", "structure_bytes");
  expect_spread(bytes.mean, 1, 1, 1);  // sqrt(0.5 * 2)
  EXPECT_EQ(bytes.worst_scene, "b");
  expect_spread(bytes.worst, 2, 2, 2);
  EXPECT_EQ(bytes.threads, 2u);
  EXPECT_NEAR(find(all, "stbvh", "embree", "total_bytes").worst.median, 1.5, 1e-12);
  EXPECT_NEAR(find(all, "stbvh", "embree", "build_s").mean.median, 2, 1e-12);
  EXPECT_NEAR(find(all, "stbvh", "lbvh", "build_s").worst.median, 2, 1e-12);
}

TEST(Summary, BounceUniformAndShadowCountTogether) {
  Report report = two_scenes();
  for (const char* scene : {"a", "b"}) {
    for (const char* rays : {"uniform", "shadow", "primary"})
      report.speeds.push_back(speed(scene, "embree", rays, {1, 1}));
  }
  report.speeds.push_back(speed("a", "stbvh", "uniform", {8, 1}));
  report.speeds.push_back(speed("a", "stbvh", "shadow", {1, 2}));
  report.speeds.push_back(speed("b", "stbvh", "uniform", {4, 9}));
  report.speeds.push_back(speed("b", "stbvh", "shadow", {4, 9}));
  report.speeds.push_back(speed("a", "stbvh", "primary", {100, 100}));
  const SummaryResult together =
      find(summarize_scenes(report), "stbvh", "embree", "speed", "bounce+uniform+shadow");
  expect_spread(together.mean, (std::sqrt(8.0) + std::sqrt(18.0)) / 2, std::sqrt(8.0), std::sqrt(18.0));
  EXPECT_EQ(together.worst_scene, "a");
  expect_spread(together.worst, 2, 2, 2);  // cbrt(1 * 8 * 1) and cbrt(4 * 1 * 2)
}

TEST(Summary, WithoutAllThreeKindsThereIsNoneTogether) {
  for (const SummaryResult& r : summarize_scenes(two_scenes()))
    EXPECT_EQ(r.rays.find('+'), std::string::npos);
}

TEST(Summary, ThreadCountsStandApart) {
  Report report = two_scenes();
  for (const char* scene : {"a", "b"}) {
    report.speeds.push_back(speed(scene, "embree", "bounce", {1}, 2));
    report.speeds.push_back(speed(scene, "stbvh", "bounce", {3}, 2));
  }
  const auto all = summarize_scenes(report);
  expect_spread(find(all, "stbvh", "embree", "speed", "bounce", 1).mean, 4, 2, 6);
  expect_spread(find(all, "stbvh", "embree", "speed", "bounce", 2).mean, 3, 3, 3);
  EXPECT_NE(summary_table(all).find("bounce, 2 threads"), std::string::npos);
}

TEST(Summary, ScenesThatLackAStructureDoNotCount) {
  Report report = two_scenes();
  report.speeds.pop_back();
  report.builds.pop_back();
  const auto all = summarize_scenes(report);
  const SummaryResult speeds = find(all, "stbvh", "embree", "speed", "bounce");
  EXPECT_EQ(speeds.scenes, 1u);
  expect_spread(speeds.mean, 2.5, 1, 4);
  EXPECT_NE(summary_table(all).find("stbvh against embree: 1 of 2 scenes"), std::string::npos);
  EXPECT_EQ(summary_table(summarize_scenes(two_scenes())).find(" of 2 scenes"), std::string::npos);
}

TEST(Summary, WithoutTheReferenceThereIsNoRatio) {
  Report report = two_scenes();
  for (SpeedResult& r : report.speeds) r.ratios_to_embree.clear();
  for (const SummaryResult& r : summarize_scenes(report)) EXPECT_NE(r.measure, "speed");
}

TEST(Summary, OfOneSceneIsNone) {
  Report report = two_scenes();
  report.builds.resize(3);
  report.speeds.resize(3);
  EXPECT_TRUE(summarize_scenes(report).empty());
  EXPECT_EQ(summary_table({}), "");
}

/// The line of `text` that begins with `start`.
std::string line_of(const std::string& text, const std::string& start) {
  const std::size_t begin = text.find("\n" + start + " ");
  return begin == std::string::npos ? "" : text.substr(begin + 1, text.find('\n', begin + 1) - begin - 1);
}

TEST(Screen, HasALineForEachStructure) {
  Report report = two_scenes();
  const std::string screen = summary_screen(summarize_scenes(report));
  EXPECT_EQ(line_of(screen, "stbvh"),
            "stbvh                     4.00  4.00 (2.00-6.00)  2.50 a                  1.00   2.00");
  report.builds.pop_back();
  report.speeds.pop_back();
  EXPECT_NE(line_of(summary_screen(summarize_scenes(report)), "stbvh").find("(1 of 2 scenes)"),
            std::string::npos);
  EXPECT_EQ(summary_screen({}), "");
}

TEST(Screen, CountsWrongAnswersOverAllScenes) {
  ErrorResult a{.scene = "a", .structure = "lbvh", .rays = "bounce", .traced = 100, .missed = 2};
  ErrorResult b{
      .scene = "b", .structure = "lbvh", .rays = "shadow", .traced = 200, .missed = 3, .false_hits = 1};
  a.distance.relative.p99 = 0.25;
  const std::string line = line_of(error_screen({a, b}), "lbvh");
  EXPECT_EQ(line, "lbvh                       300             5             1  0 (<1.0e-02)   2.5e-01");
  EXPECT_EQ(error_screen({}), "");
}

TEST(Screen, NamesTheWorstFamilyOfHardCases) {
  const HardResult closed{.family = "closed", .structure = "embree", .traced = 50, .leaks = 5, .missed = 4};
  const HardResult needles{
      .family = "needles", .structure = "embree", .traced = 150, .wrong_primitive = 6, .any_hit_wrong = 1};
  const HardResult ours{.family = "closed", .structure = "stbvh", .traced = 50, .leaks = 0};
  const std::string screen = hard_screen({closed, needles, ours});
  EXPECT_EQ(
      line_of(screen, "embree"),
      "embree                     200        5 (10 %)        10 (5 %)       1 (0.5 %)  needles: 6 of 150");
  EXPECT_EQ(line_of(screen, "stbvh"),
            "stbvh                       50               0               0               0  -");
  EXPECT_EQ(hard_screen({}), "");
}

TEST(Summary, StandsInTheTableAndInTheRecords) {
  Report report = two_scenes();
  report.summaries = summarize_scenes(report);
  const std::string table = summary_table(report.summaries);
  EXPECT_NE(table.find("4.00 2.00-6.00  2.50 1.00-4.00 a"), std::string::npos) << table;
  EXPECT_NE(table.find("2.00 b"), std::string::npos) << table;
  const auto records = nlohmann::json::parse(to_json(report, Machine{}, "")).at("records");
  EXPECT_EQ(records[8]["ratios_to_embree"], nlohmann::json({1.0, 4.0}));
  const auto& first = records[report.builds.size() + report.speeds.size()];
  EXPECT_EQ(first["kind"], "summary");
  for (const char* field :
       {"structure", "reference", "measure", "rays", "threads", "scenes", "mean_ratio", "mean_ratio_min",
        "mean_ratio_max", "worst_scene", "worst_ratio", "worst_ratio_min", "worst_ratio_max"})
    EXPECT_TRUE(first.contains(field)) << field;
  EXPECT_TRUE(records.back()["rays"].is_null());
}

}  // namespace
}  // namespace stbvh::harness
