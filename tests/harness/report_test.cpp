#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "harness/report/json.h"
#include "harness/report/read_records.h"
#include "harness/report/table.h"
#include "plugin/files/output_file.h"
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
  write_file(file, R"({"machine": {}, "commit": "", "records": [{"kind": "speed"}]})");
  EXPECT_THROW(read_speeds_and_hards(file), RecordFileError);
  fs::remove(file);
  EXPECT_THROW(read_speeds_and_hards(file), RecordFileError);
  ASSERT_EQ(back.speeds.size(), 1u);
  EXPECT_EQ(back.speeds[0].ratios_to_embree, report.speeds[0].ratios_to_embree);
  EXPECT_EQ(back.speeds[0].threads, 2u);
  ASSERT_EQ(back.hards.size(), 2u);
  EXPECT_EQ(back.hards[0].leaks, 3u);
  EXPECT_EQ(back.hards[0].within_rounding, 7u);
  EXPECT_FALSE(back.hards[1].leaks.has_value());
}

class RecordFile : public TemporaryFolderTest {
 protected:
  static std::string file_of(const std::string& record) {
    return R"({"machine": {}, "commit": "", "records": [)" + record + "]}";
  }
  std::string refusal_of(const std::string& text) const {
    try {
      read_speeds_and_hards(write("records.json", text));
    } catch (const RecordFileError& e) {
      const std::string message = e.what();
      EXPECT_NE(message.find(at("records.json")), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      return message;
    }
    return "";
  }
  void expect_refused(const std::string& text, const std::string& reason) const {
    const std::string message = refusal_of(text);
    EXPECT_NE(message.find(reason), std::string::npos) << message << "\n" << text.substr(0, 200);
  }
};

std::string repeated(const std::string& part, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += part;
  return text;
}

TEST_F(RecordFile, ThatIsTooDeepIsRefused) {
  constexpr std::size_t kLevels = 200000;
  const std::string arrays = repeated("[", kLevels) + repeated("]", kLevels);
  const std::string objects = repeated(R"({"a":)", kLevels) + "1" + repeated("}", kLevels);
  for (const std::string& deep : {arrays, objects}) {
    expect_refused(deep, "nested more than 100 levels deep");
    expect_refused(file_of(deep), "nested more than 100 levels deep");
    expect_refused(R"({"records": )" + deep + "}", "nested more than 100 levels deep");
  }
  expect_refused(repeated("[", kLevels), "nested more than 100 levels deep");
  expect_refused(file_of(R"({"kind": "other", "a": )" + repeated("[", 90) + repeated("]", 90) + "}"), "");
}

TEST_F(RecordFile, ThatIsTooLargeIsRefusedByItsSize) {
  write("records.json", file_of(R"({"kind": "other"})"));
  fs::resize_file(folder / "records.json", std::uintmax_t{100} << 30);
  try {
    read_speeds_and_hards(folder / "records.json");
    ADD_FAILURE();
  } catch (const RecordFileError& e) {
    EXPECT_NE(std::string(e.what()).find("107374182400 bytes, but at most 67108864"), std::string::npos)
        << e.what();
  }
}

TEST_F(RecordFile, OfOtherContentIsRefusedByName) {
  const std::string speed = to_json(small_report(), Machine{}, "abc");
  ASSERT_EQ(refusal_of(speed), "");
  EXPECT_EQ(refusal_of("\xEF\xBB\xBF" + speed), "");  // a byte order mark
  const auto with = [&](const std::string& field, const std::string& value) {
    std::string text = speed;
    const std::size_t begin =
        text.find("\"" + field + "\": ", text.find("\"kind\": \"speed\"")) + field.size() + 4;
    return text.replace(begin, text.find_first_of(",\n", begin) - begin, value);
  };
  ASSERT_EQ(refusal_of(with("repeats", "7")), "");
  for (const char* wrong :
       {"-1", "1.5", "1e300", "\"7\"", "null", "[7]", "{}", "true", "99999999999999999999"})
    expect_refused(with("repeats", wrong), "whose \"repeats\" is not a count");
  expect_refused(with("scene", "7"), "whose \"scene\" is not a text");
  for (const char* wrong : {"[0]", "[-1]", "[\"1\"]", "[null]", "[[1]]", "1", "{}"})
    expect_refused(with("ratios_to_embree", std::string(wrong) + ", \"other\": ["), "\"ratios_to_embree\"");
  for (const char* wrong : {"NaN", "Infinity", "1e999", "-1e999", "01", "0x10"})
    expect_refused(with("repeats", wrong), "is not whole JSON");
  expect_refused(with("repeats", "7, \"repeats\": 8"), "has \"repeats\" twice");
  expect_refused(file_of(R"({"kind": "speed"})"), "lacks \"scene\"");
  expect_refused(file_of("7"), "not an object");
  expect_refused(file_of(R"({"kind": 7})"), "\"kind\" is not a text");
  expect_refused(speed + speed, "is not whole JSON");
  expect_refused(std::string("\xFF\xFE{\0}\0", 6), "is not whole JSON");  // UTF-16
  expect_refused("[]", "does not hold records");
}

TEST_F(RecordFile, WhatIsNoFileIsRefused) {
  fs::create_symlink(folder / "b", folder / "a");
  fs::create_symlink(folder / "a", folder / "b");
  for (const fs::path& path : {folder / "a", folder / "none", folder})
    EXPECT_THROW(read_speeds_and_hards(path), RecordFileError);
}

}  // namespace
}  // namespace stbvh::harness
