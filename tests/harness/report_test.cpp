#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "plugin/files/output_file.h"
#include "harness/report/json.h"
#include "harness/report/read_records.h"
#include "harness/report/table.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

Report small_report() {
  Report report;
  report.builds.push_back(
      {.scene = "s", .structure = "embree", .build_s = {2, 1, 3}, .structure_bytes = 100});
  report.speeds.push_back({.scene = "s",
                           .structure = "embree",
                           .rays = "bounce",
                           .ray_count = 10,
                           .threads = 1,
                           .repeats = 7,
                           .mrays_per_s = {2, 1, 3},
                           .ratios_to_embree = {1, 1, 1},
                           .hits = 4});
  report.errors.push_back({.scene = "s", .structure = "embree", .rays = "bounce", .traced = 30});
  report.hards.push_back({.family = "f", .structure = "embree", .traced = 30, .leaks = 2});
  return report;
}

TEST(Json, HasTheFieldsThatOthersRead) {
  Machine machine;
  machine.cpu = "c";
  const auto json = nlohmann::json::parse(to_json(small_report(), machine, "abc"));
  EXPECT_EQ(json.at("machine").at("cpu"), "c");
  EXPECT_EQ(json.at("commit"), "abc");
  ASSERT_EQ(json.at("records").size(), 4u);
  const std::vector<std::vector<const char*>> fields{
      {"kind", "scene", "structure", "triangles", "primitive_segments", "build_s", "peak_bytes",
       "structure_bytes", "total_bytes"},
      {"kind", "scene", "structure", "rays", "threads", "repeats", "mrays_per_s", "mrays_per_s_min",
       "mrays_per_s_max", "ratio_to_embree", "hits"},
      {"kind", "scene", "structure", "rays", "traced", "missed", "false_hits", "wrong_primitive",
       "t_error_rel_p50", "t_error_rel_p99", "t_error_rel_max", "t_error_ulps_p99", "off_plane_p99",
       "grazing"},
      {"kind", "family", "structure", "traced", "leaks", "missed", "false_hits", "wrong_primitive",
       "any_hit_wrong", "self_hits", "exact_self_hits", "within_rounding", "ties", "t_error_rel_p99",
       "t_error_ulps_max", "off_plane_p99"}};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    for (const char* field : fields[i]) EXPECT_TRUE(json["records"][i].contains(field)) << field;
  }
  EXPECT_EQ(json["records"][0]["kind"], "build");
  EXPECT_EQ(json["records"][1]["kind"], "speed");
  EXPECT_EQ(json["records"][2]["kind"], "error");
  EXPECT_EQ(json["records"][3]["kind"], "hard");
  EXPECT_EQ(json["records"][3]["leaks"], 2);
  EXPECT_TRUE(json["records"][3]["self_hits"].is_null());
  EXPECT_EQ(json["records"][1]["ratio_to_embree"], 1.0);
}

TEST(Json, RatioWithoutReferenceIsNull) {
  Report report = small_report();
  report.speeds[0].ratios_to_embree.clear();
  const auto json = nlohmann::json::parse(to_json(report, Machine{}, ""));
  EXPECT_TRUE(json["records"][1]["ratio_to_embree"].is_null());
}

TEST(Json, NamesThatAreNotUtf8StayReadable) {
  Report report = small_report();
  report.builds[0].scene = "\xff";
  EXPECT_TRUE(nlohmann::json::accept(to_json(report, Machine{}, "")));
}

TEST(Spread, MedianOfOddAndEvenCounts) {
  EXPECT_EQ(spread_of({3, 1, 2}).median, 2);
  EXPECT_EQ(spread_of({4, 1, 2, 3}).median, 2.5);
  EXPECT_EQ(spread_of({4, 1}).min, 1);
  EXPECT_EQ(spread_of({4, 1}).max, 4);
}

TEST(Table, NoBadRayInSomeManySaysWhatItProves) {
  EXPECT_EQ(bad_count(0, 20000), "0 (<1.5e-04)");
  EXPECT_EQ(bad_count(3, 20000), "3");
}

TEST(Table, HardRowsLineUpWithTheirHeading) {
  HardResult result{.family = "direction-lengths-1e20", .structure = "stbvh-direct-indexed", .traced = 20000};
  EXPECT_EQ(hard_row(result).size(), hard_heading().size());
  EXPECT_NE(hard_row(result).find("0 (<1.5e-04)"), std::string::npos);
  EXPECT_EQ(hard_row(result).find(" 12 "), std::string::npos);
  result.leaks = 12;
  EXPECT_NE(hard_row(result).find(" 12 "), std::string::npos);
}

TEST(Table, ShowsRatiosAndSpread) {
  const Report report = small_report();
  EXPECT_NE(speed_table(report.speeds).find("1.00 (1.00-1.00)"), std::string::npos);
  EXPECT_NE(build_table(report.builds).find("1.00-3.00 (0)"), std::string::npos);
  EXPECT_NE(error_table(report.errors).find("0 (<1.0e-01)"), std::string::npos);
}

TEST(Table, ScalingIsForEachTriangle) {
  const BuildResult build{.scene = "s",
                          .structure = "embree",
                          .triangles = 1000,
                          .build_s = {0.002, 0.001, 0.003},
                          .peak_bytes = 9000,
                          .structure_bytes = 4000};
  const SpeedResult speed{.scene = "s", .structure = "embree", .rays = "bounce", .mrays_per_s = {3, 2, 4}};
  const std::vector<ScalingResult> results{{.over = "steps", .value = 17, .build = build, .speeds = {speed}}};
  const std::string table = scaling_table(results);
  std::istringstream last_row(table.substr(table.find("\nembree") + 1));
  std::string structure;
  double value, triangles, seconds, ns, megabytes, bytes, peak, mrays;
  last_row >> structure >> value >> triangles >> seconds >> ns >> megabytes >> bytes >> peak >> mrays;
  EXPECT_EQ(value, 17);
  EXPECT_EQ(triangles, 1000);
  EXPECT_EQ(ns, 2000);
  EXPECT_EQ(bytes, 4);
  EXPECT_EQ(peak, 9);
  EXPECT_EQ(mrays, 3);
  EXPECT_EQ(scaling_table({}), "");

  Report report;
  report.scalings = results;
  const auto record = nlohmann::json::parse(to_json(report, Machine{}, ""))["records"][0];
  EXPECT_EQ(record["kind"], "scaling");
  EXPECT_EQ(record["over"], "steps");
  EXPECT_EQ(record["value"], 17);
  EXPECT_EQ(record["build_s_max"], 0.003);
  EXPECT_EQ(record["bounce_mrays_per_s"], 3);
  EXPECT_EQ(record["bounce_mrays_per_s_min"], 2);
}

TEST(RateBound, OfNothingFoundIsThreeByN) {
  EXPECT_DOUBLE_EQ(rate_bound_95(0, 1000), 3e-3);
  EXPECT_DOUBLE_EQ(rate_bound_95(0, 0), 1);
  EXPECT_DOUBLE_EQ(rate_bound_95(9, 2), 1);
  // Poisson's own bounds at 95 %: 4.744 for 1, 16.96 for 10, 118.1 for 100.
  EXPECT_NEAR(rate_bound_95(1, 1000), 4.744e-3, 5e-5);
  EXPECT_NEAR(rate_bound_95(10, 1000), 16.96e-3, 5e-5);
  EXPECT_NEAR(rate_bound_95(100, 1000), 118.1e-3, 1e-4);
}

TEST(Json, SpeedsAndHardCasesComeBack) {
  Report report;
  SpeedResult speed;
  speed.structure = "stbvh";
  speed.threads = 2;
  speed.ratios_to_embree = {1.5, 1.25, 2};
  report.speeds = {speed};
  HardResult hard;
  hard.leaks = 3;
  hard.within_rounding = 7;
  hard.distance.relative.p99 = std::numeric_limits<double>::infinity();  // null in JSON
  report.hards = {hard, HardResult{}};
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "records.json";
  write_file(file, to_json(report, Machine{}, "abc", "stbvh-ab bench"));
  const Report back = read_speeds_and_hards(file);
  EXPECT_NO_THROW(check_records(file));
  write_file(file, R"({"machine": {}, "commit": "", "records": [{"kind": "speed"}]})");
  EXPECT_THROW(read_speeds_and_hards(file), RecordFileError);
  fs::remove(file);
  EXPECT_THROW(check_records(file), RecordFileError);
  ASSERT_EQ(back.speeds.size(), 1u);
  EXPECT_EQ(back.speeds[0].ratios_to_embree, report.speeds[0].ratios_to_embree);
  EXPECT_EQ(back.speeds[0].threads, 2u);
  ASSERT_EQ(back.hards.size(), 2u);
  EXPECT_EQ(back.hards[0].leaks, 3u);
  EXPECT_EQ(back.hards[0].within_rounding, 7u);
  EXPECT_FALSE(back.hards[1].leaks.has_value());
}

}  // namespace
}  // namespace stbvh::harness
