/// `stbvh-ab charts` on records made up here.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "harness/files/output_file.h"
#include "harness/report/json.h"
#include "harness/report/summary.h"
#include "tests/harness/run_stbvh_ab.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

/// Two scenes, three structures (one of them not in the registry), two thread counts.
Report bench_report() {
  Report report;
  for (const char* scene : {"a", "b"}) {
    double speed = 1;
    for (const char* structure : {"embree", "stbvh", "new-tree"}) {
      report.builds.push_back({.scene = scene,
                               .structure = structure,
                               .triangles = 10,
                               .threads = 2,
                               .builds = 1,
                               .build_s = {speed, speed, speed},
                               .peak_bytes = 300,
                               .structure_bytes = 200,
                               .total_bytes = 250});
      for (unsigned threads : {1u, 2u}) {
        report.speeds.push_back({.scene = scene,
                                 .structure = structure,
                                 .rays = "bounce",
                                 .ray_count = 10,
                                 .threads = threads,
                                 .repeats = 2,
                                 .mrays_per_s = {speed, speed, speed},
                                 .ratios_to_embree = {speed, 1.5 * speed}});
      }
      speed += 0.5;
    }
  }
  report.summaries = summarize_scenes(report);
  return report;
}

Report scaling_report() {
  Report report;
  for (const char* over : {"steps", "triangles", "threads"}) {
    for (std::size_t value : {1u, 2u}) {
      BuildResult build = bench_report().builds.front();
      build.threads = static_cast<unsigned>(value);
      ScalingResult result{.over = over, .value = value, .build = build};
      if (result.over != "triangles") result.speeds = {bench_report().speeds.front()};
      report.scalings.push_back(result);
    }
  }
  return report;
}

class Charts : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(directory_);
    write("bench.json", to_json(bench_report(), Machine{}, "abc"));
    write("scaling.json", to_json(scaling_report(), Machine{}, "def"));
  }
  void TearDown() override { fs::remove_all(directory_); }

  void write(const std::string& name, const std::string& text) { write_file(directory_ / name, text); }

  Outcome charts(const std::string& files, const std::string& rest = "") {
    return stbvh_ab("charts " + files + " -o " + (directory_ / "charts").string() + " " + rest);
  }

  std::string path(const std::string& name) const { return (directory_ / name).string(); }

  std::set<std::string> drawn() const {
    std::set<std::string> names;
    if (!fs::exists(directory_ / "charts")) return names;
    for (const auto& entry : fs::directory_iterator(directory_ / "charts"))
      names.insert(entry.path().filename().string());
    return names;
  }

  std::string content(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(directory_ / "charts" / name).rdbuf();
    return text.str();
  }

  void expect_refused(const Outcome& run, const std::string& reason) {
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1) << run.out;
    EXPECT_TRUE(run.out.starts_with("stbvh-ab: ")) << run.out;
    EXPECT_NE(run.out.find(reason), std::string::npos) << run.out;
    EXPECT_TRUE(drawn().empty());
  }

  const fs::path directory_ = fs::temp_directory_path() / ("stbvh_charts_test_" + std::to_string(getpid()));
};

TEST_F(Charts, AreDrawnOfWhateverTheRecordsHold) {
  const Outcome run = charts(path("bench.json") + " " + path("scaling.json"));
  EXPECT_EQ(run.exit_code, 0) << run.out;
  const std::set<std::string> expected{"speed-to-embree-1-threads.svg",
                                       "speed-to-embree-2-threads.svg",
                                       "speed-bounce-1-threads.svg",
                                       "speed-bounce-2-threads.svg",
                                       "bytes.svg",
                                       "bytes-with-buffers.svg",
                                       "build-time.svg",
                                       "scaling-steps-a.svg",
                                       "scaling-triangles-a.svg",
                                       "scaling-threads-a.svg"};
  EXPECT_EQ(drawn(), expected) << run.out;
  for (const std::string& name : drawn()) {
    EXPECT_TRUE(content(name).starts_with("<?xml")) << name;
    EXPECT_NE(content(name).find("</svg>"), std::string::npos) << name;
    EXPECT_NE(run.out.find(name + "\n"), std::string::npos) << name;
  }
}

TEST_F(Charts, OfTheSameRecordsAreTheSameBytes) {
  EXPECT_EQ(charts(path("scaling.json")).exit_code, 0);
  const std::string first = content("scaling-steps-a.svg");
  EXPECT_EQ(charts(path("scaling.json")).exit_code, 0);
  EXPECT_EQ(content("scaling-steps-a.svg"), first);
}

TEST_F(Charts, HoldTheStructuresAskedFor) {
  EXPECT_EQ(charts(path("bench.json")).exit_code, 0);
  const std::string of_all = content("bytes.svg");
  const Outcome run = charts(path("bench.json"), "--structures new-tree,embree");
  EXPECT_EQ(run.exit_code, 0) << run.out;
  EXPECT_LT(content("bytes.svg").size(), of_all.size());
}

TEST_F(Charts, ArePngIfAskedFor) {
  EXPECT_EQ(charts(path("scaling.json"), "--format png").exit_code, 0);
  EXPECT_EQ(drawn().size(), 3u);
  for (const std::string& name : drawn()) EXPECT_TRUE(content(name).starts_with("\x89PNG")) << name;
}

TEST_F(Charts, WithoutRecordsToDrawAreRefused) {
  const std::string whole = to_json(bench_report(), Machine{}, "abc");
  write("truncated.json", whole.substr(0, whole.size() / 2));
  write("empty.json", to_json(Report{}, Machine{}, "abc"));
  write("nothing.json", "");
  write("other.json", "[1, 2]");
  Report errors;
  errors.errors.push_back({.scene = "a", .structure = "embree", .rays = "bounce"});
  write("errors.json", to_json(errors, Machine{}, "abc"));
  expect_refused(charts(path("no-such.json")), "Cannot read");
  expect_refused(charts(path("truncated.json")), "not whole JSON");
  expect_refused(charts(path("nothing.json")), "not whole JSON");
  expect_refused(charts(path("empty.json")), "no records");
  expect_refused(charts(path("other.json")), "does not hold records");
  expect_refused(charts(path("errors.json")), "nothing to draw");
  expect_refused(charts(path("bench.json") + " " + path("bench.json")), "records of the same");
  expect_refused(charts(path("bench.json"), "--structures lbvh"), "\"lbvh\"");
}

TEST_F(Charts, WhereNothingCanBeWrittenAreRefused) {
  expect_refused(stbvh_ab("charts " + path("bench.json") + " -o /proc/none"), "Cannot make the directory");
  expect_refused(stbvh_ab("charts " + path("bench.json") + " -o " + path("bench.json")),
                 "Cannot make the directory");
  expect_refused(stbvh_ab("charts " + path("bench.json") + " -o /proc/self/fdinfo"), "Cannot write to");
}

}  // namespace
}  // namespace stbvh::harness
