/// `stbvh-ab charts` on records made up here.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>

#include "harness/report/json.h"
#include "tests/harness/bench_records.h"
#include "tests/harness/gallery_records.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

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

class Charts : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    write("bench.json", to_json(bench_report(), Machine{}, "abc"));
    write("scaling.json", to_json(scaling_report(), Machine{}, "def"));
  }

  Outcome charts(const std::string& files, const std::string& rest = "") {
    return stbvh_ab("charts " + files + " -o " + at("charts") + " " + rest);
  }

  std::set<std::string> drawn() const {
    std::set<std::string> names;
    if (!fs::exists(folder / "charts")) return names;
    for (const auto& entry : fs::directory_iterator(folder / "charts"))
      names.insert(entry.path().filename().string());
    return names;
  }

  std::string content(const std::string& name) const { return read_file(folder / "charts" / name); }

  void expect_refused(const Outcome& run, const std::string& reason) {
    expect_refusal(run, reason);
    EXPECT_TRUE(drawn().empty());
  }
};

TEST_F(Charts, AreDrawnOfWhateverTheRecordsHold) {
  const Outcome run = charts(at("bench.json") + " " + at("scaling.json"));
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

// As of benchmarks that several machines made, a scene each.
TEST_F(Charts, JoinScenesMeasuredApartOnMachinesOfOneType) {
  Report whole = bench_report();
  Report a, b;
  for (const BuildResult& build : whole.builds) (build.scene == "a" ? a : b).builds.push_back(build);
  for (const SpeedResult& speed : whole.speeds) (speed.scene == "a" ? a : b).speeds.push_back(speed);
  whole.summaries.clear();
  Machine machine{.cpu = "cpu", .cores = 8, .memory_gb = 1, .instruction_set = "avx2", .embree = "3.13.5"};
  write("whole.json", to_json(whole, machine, "abc"));
  write("a.json", to_json(a, machine, "abc"));
  machine.memory_gb = 2;
  write("b.json", to_json(b, machine, "abc"));
  ASSERT_EQ(charts(at("whole.json")).exit_code, 0);
  const std::string expected = content("speed-bounce-1-threads.svg");
  fs::remove_all(folder / "charts");
  ASSERT_EQ(charts(at("a.json") + " " + at("b.json")).exit_code, 0);
  EXPECT_EQ(content("speed-bounce-1-threads.svg"), expected);
  fs::remove_all(folder / "charts");

  const auto refused = [&](const Machine& other) {
    write("other.json", to_json(b, other, "abc"));
    const std::string reason = "machines of two types: cpu, 8 cores, Embree 3.13.5; ";
    expect_refusal(charts(at("a.json") + " " + at("other.json")), reason);
    expect_refusal(stbvh_ab("pareto --from " + at("a.json") + "," + at("other.json")), reason);
  };
  Machine other = machine;
  other.cpu = "another";
  refused(other);
  other = machine;
  other.cores = 4;
  refused(other);
  other = machine;
  other.embree = "4.3.3";
  refused(other);
  const Outcome same = stbvh_ab("pareto --from " + at("a.json") + "," + at("b.json"));
  EXPECT_NE(same.out.find("no structure has both"), std::string::npos) << same.out;
}

TEST_F(Charts, OfAGalleryAreItsOwn) {
  write("gallery.json", to_json(gallery_report(), Machine{}, "abc"));
  const Outcome run = charts(at("gallery.json"));
  EXPECT_EQ(run.exit_code, 0) << run.out;
  const std::set<std::string> expected{
      "gallery.svg",          "gallery-steps.svg",  "gallery-quarter-turns.svg",
      "gallery-separate.svg", "gallery-slices.svg", "gallery-slices-ours.svg"};
  EXPECT_EQ(drawn(), expected) << run.out;
  for (const std::string& name : drawn()) EXPECT_NE(content(name).find("</svg>"), std::string::npos) << name;
  const std::string first = content("gallery-slices.svg");
  EXPECT_EQ(charts(at("gallery.json")).exit_code, 0);
  EXPECT_EQ(content("gallery-slices.svg"), first);
}

TEST_F(Charts, OfAGalleryNeedNotHoldEverything) {
  Report report = gallery_report();
  report.scalings.clear();
  report.slices.clear();
  report.speeds.clear();  // of scenes that Embree does not take there are no ratios
  std::erase_if(report.summaries, [](const SummaryResult& r) { return r.measure == "speed"; });
  std::erase_if(report.galleries, [](const GalleryResult& r) { return r.structure == "separate-2"; });
  write("gallery.json", to_json(report, Machine{}, "abc"));
  const Outcome run = charts(at("gallery.json"));
  EXPECT_EQ(run.exit_code, 0) << run.out;
  EXPECT_EQ(drawn(), std::set<std::string>{"gallery.svg"}) << run.out;
}

TEST_F(Charts, OfABrokenGalleryAreRefused) {
  const auto refused = [&](const std::string& from, const std::string& to, const std::string& reason) {
    std::string text = to_json(gallery_report(), Machine{}, "abc");
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << from;
    write("broken.json", text.replace(place, from.size(), to));
    const Outcome run = charts(at("broken.json"));
    EXPECT_EQ(run.exit_code, 2) << run.out;
    const std::size_t line = run.out.rfind("stbvh-ab: ");  // below the names of what had been drawn
    ASSERT_NE(line, std::string::npos) << run.out;
    EXPECT_NE(run.out.find(reason, line), std::string::npos) << run.out;
    EXPECT_EQ(std::count(run.out.begin() + static_cast<std::ptrdiff_t>(line), run.out.end(), '\n'), 1)
        << run.out;
  };
  refused("\"step_limit\": \"any\"", "\"step_limit\": 7", "\"step_limit\" is not a text");
  refused("\"wrong\": 0", "\"wrong\": \"x\"", "\"wrong\" is not a number");
  refused("\"compared_with\"", "\"what\"", "lack the field");
  refused("\"shapes\": [", "\"shapes\": [7,", "do not hold what they should");
}

TEST_F(Charts, OfTheSameRecordsAreTheSameBytes) {
  EXPECT_EQ(charts(at("scaling.json")).exit_code, 0);
  const std::string first = content("scaling-steps-a.svg");
  EXPECT_EQ(charts(at("scaling.json")).exit_code, 0);
  EXPECT_EQ(content("scaling-steps-a.svg"), first);
}

TEST_F(Charts, HoldTheStructuresAskedFor) {
  EXPECT_EQ(charts(at("bench.json")).exit_code, 0);
  const std::string of_all = content("bytes.svg");
  const Outcome run = charts(at("bench.json"), "--structures new-tree,embree");
  EXPECT_EQ(run.exit_code, 0) << run.out;
  EXPECT_LT(content("bytes.svg").size(), of_all.size());
}

TEST_F(Charts, ArePngIfAskedFor) {
  EXPECT_EQ(charts(at("scaling.json"), "--format png").exit_code, 0);
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
  expect_refused(charts(at("no-such.json")), "Cannot read");
  expect_refused(charts(at("truncated.json")), "not whole JSON");
  expect_refused(charts(at("nothing.json")), "not whole JSON");
  expect_refused(charts(at("empty.json")), "no records");
  expect_refused(charts(at("other.json")), "does not hold records");
  expect_refused(charts(at("errors.json")), "nothing to draw");
  expect_refused(charts(at("bench.json") + " " + at("bench.json")), "records of the same");
  expect_refused(charts(at("bench.json"), "--structures lbvh"), "\"lbvh\"");
}

TEST_F(Charts, OfRecordsThatAreBrokenAreRefusedInOneLine) {
  const std::string whole = to_json(scaling_report(), Machine{}, "abc");
  const auto refused = [&](const std::string& text, const std::string& reason) {
    write("broken.json", text);
    expect_refused(charts(at("broken.json")), reason);
  };
  const auto with = [&](const std::string& field, const std::string& value) {
    std::string text = whole;
    const std::size_t begin = text.find("\"" + field + "\": ") + field.size() + 4;
    return text.replace(begin, text.find_first_of(",\n", begin) - begin, value);
  };
  refused(std::string(200000, '[') + std::string(200000, ']'), "nested too deeply");
  refused(with("build_s", std::string(200000, '[') + std::string(200000, ']')), "nested too deeply");
  refused(with("build_s", "[[1]]"), "\"build_s\" is not a number");
  refused(with("build_s", "\"1\""), "\"build_s\" is not a number");
  refused(with("build_s", "true"), "\"build_s\" is not a number");
  refused(with("scene", "7"), "\"scene\" is not a text");
  refused(with("build_s", "NaN"), "NaN is not a finite number");
  refused(with("build_s", "1e999"), "1e999 is not a finite number");
  refused(with("build_s", std::string(5000, '9')), "has too many digits");
  refused(with("build_s", "1, \"build_s\": 2"), "\"build_s\" stands twice");
  refused(with("build_s_max", "-1e300"), "not");
  refused(std::string("\xFF\xFE{\0}\0", 6), "not whole JSON");
  write("sparse.json", "");
  fs::resize_file(folder / "sparse.json", std::uintmax_t{100} << 30);
  expect_refused(charts(at("sparse.json")), "more than the 67108864 bytes");
}

TEST_F(Charts, AreDrawnOfScenesOfAnyName) {
  Report report = scaling_report();
  for (const std::string name : {"$\\frac{", "../../up", "a\nb\x1b[31m", "\xE6\xBC\xA2", "<&\">"}) {
    for (ScalingResult& result : report.scalings) result.build.scene = name;
    write("names.json", "\xEF\xBB\xBF" + to_json(report, Machine{}, "abc"));  // with a byte order mark
    const Outcome run = charts(at("names.json"));
    EXPECT_EQ(run.exit_code, 0) << run.out;
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 3) << run.out;
    EXPECT_EQ(drawn().size(), 3u) << run.out;
    fs::remove_all(folder / "charts");
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 3);
}

TEST_F(Charts, LinksStayLinksAndLoopsAreRefused) {
  ASSERT_EQ(charts(at("scaling.json")).exit_code, 0);
  const std::string first = content("scaling-steps-a.svg");
  write("elsewhere.svg", "old");
  fs::remove(folder / "charts" / "scaling-steps-a.svg");
  fs::create_symlink(folder / "elsewhere.svg", folder / "charts" / "scaling-steps-a.svg");
  ASSERT_EQ(charts(at("scaling.json")).exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(folder / "charts" / "scaling-steps-a.svg"));
  EXPECT_EQ(read_file(folder / "elsewhere.svg"), first);
  fs::remove_all(folder / "charts");
  fs::create_symlink(folder / "b", folder / "a");
  fs::create_symlink(folder / "a", folder / "b");
  expect_refused(charts(at("a")), "Too many levels of symbolic links");
  expect_refused(stbvh_ab("charts " + at("scaling.json") + " -o " + at("a")), "Cannot make the directory");
}

TEST_F(Charts, ResultsOfMachinesStandSideBySide) {
  Machine one, other;
  one.cpu = "AMD EPYC 7B13 64-Core Processor";
  other.cpu = "Intel(R) Core(TM) i7 CPU @ 3.00GHz";
  one.embree = other.embree = "3.13.5";
  Report errors;
  errors.errors.push_back({.scene = "a", .structure = "stbvh", .rays = "bounce", .traced = 1000});
  write("one.json", to_json(bench_report(), one, "abc"));
  write("other.json", to_json(bench_report(), other, "def"));
  write("error.json", to_json(errors, other, "def"));
  const std::string page = at("page.md");
  const std::string records = at("one.json") + " " + at("other.json") + " " + at("error.json");
  ASSERT_EQ(stbvh_ab("results " + records + " -o " + page).exit_code, 0);
  const std::string text = read_file(page);
  for (const char* part : {"AMD EPYC 7B13, Embree 3.13.5, 2 threads | Intel Core i7, Embree 3.13.5, 1 thread",
                           "| 2.00 (2.00 to 2.00) |", "0 of 1,000"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;

  EXPECT_EQ(text.find("versions on one machine"), std::string::npos) << text;

  write("page.md", "before\n" + text + "after\n");
  ASSERT_EQ(stbvh_ab("results " + at("one.json") + " -o " + page).exit_code, 0);
  const std::string again = read_file(page);
  EXPECT_TRUE(again.starts_with("before\n") && again.ends_with("after\n")) << again;
  EXPECT_EQ(again.find("Intel"), std::string::npos) << again;

  write("dirty.json", to_json(bench_report(), one, "abc-dirty"));
  expect_refusal(stbvh_ab("results " + at("dirty.json") + " -o " + page), "clean commit");
  expect_refusal(stbvh_ab("results " + at("one.json") + " " + at("one.json") + " -o " + page),
                 "records of the same");
  write("other.md", "no marks");
  expect_refusal(stbvh_ab("results " + at("one.json") + " -o " + at("other.md")), "does not have the lines");
}

TEST_F(Charts, ResultsOfEmbreesOnOneMachineAreComparedInRaysASecond) {
  Machine machine;
  machine.cpu = "AMD EPYC";
  machine.embree = "3.13.5";
  Report slower = bench_report();
  write("three.json", to_json(slower, machine, "abc"));
  machine.embree = "4.3.3";
  for (SpeedResult& speed : slower.speeds) speed.mrays_per_s.median *= 0.5;
  write("four.json", to_json(slower, machine, "abc"));
  const std::string page = at("page.md");
  ASSERT_EQ(stbvh_ab("results " + at("three.json") + " " + at("four.json") + " -o " + page).exit_code, 0);
  const std::string text = read_file(page);
  for (const char* part : {"Embree's versions on one machine, million rays a second",
                           "| `embree` | 1.000 | 0.500 |", "| **`stbvh`** | 1.500 | 0.750 |"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST_F(Charts, WhereNothingCanBeWrittenAreRefused) {
  expect_refused(stbvh_ab("charts " + at("bench.json") + " -o /proc/none"), "Cannot make the directory");
  expect_refused(stbvh_ab("charts " + at("bench.json") + " -o " + at("bench.json")),
                 "Cannot make the directory");
  expect_refused(stbvh_ab("charts " + at("bench.json") + " -o /proc/self/fdinfo"), "Cannot write to");
}

}  // namespace
}  // namespace stbvh::harness
