/// `stbvh-ab report` on a tiny scene, and on records made up here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "harness/report/json.h"
#include "plugin/files/output_file.h"
#include "tests/harness/gallery_records.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// How scenes are made: nothing to these scenes, but each command must be told.
constexpr const char* kOfGltf = "--shutter-mode loop --steps auto:1e-3";

/// One report for all tests: making it takes seconds.
class ReportPage : public SharedFolderTest {
 protected:
  static const Outcome& made() {
    static const Outcome outcome =
        stbvh_ab("report --quick --scenes wheels,cloth --scale 0.01 " + std::string(kOfGltf) +
                 " --structures embree,lbvh,stbvh -o " + path("page"));
    return outcome;
  }

  /// What tests/harness/check_page.py finds wrong; empty if nothing is.
  static std::string problems(const std::string& folder, const std::string& words) {
    const std::string list = path("problems.txt");
    const std::string command = "/usr/bin/python3 -B " STBVH_SOURCE_DIR "/tests/harness/check_page.py " +
                                folder + " " + words + " > " + list + " 2>&1";
    const int status = std::system(command.c_str());
    return read_file(list) + (status == 0 ? "" : "failed");
  }

  static void expect_refused(const std::string& arguments, const std::string& reason) {
    expect_refusal(stbvh_ab("report " + arguments), reason);
  }
};

TEST_F(ReportPage, NeedsNothingElseAndHoldsEveryPart) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  EXPECT_TRUE(holds(made().out, path("page/index.html"))) << made().out;
  EXPECT_EQ(problems(path("page"),
                     "embree lbvh stbvh wheels cloth closed-2k-8 Summary 'Hard cases' 'Speed against error' "
                     "Renderings 'Frozen times' 'stbvh-ab bench' 'stbvh-ab truth' RMSE"),
            "");
  EXPECT_TRUE(holds(read_file(path("page/index.html")), "<svg"));
}

TEST_F(ReportPage, PrintsAScreenAndWritesTheTables) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  // One line more for each structure that harness/run compares: nine, in each of three summaries.
  EXPECT_LE(std::count(made().out.begin(), made().out.end(), '\n') + 3 * (9 - 3), 55) << made().out;
  for (const char* summary : {"bytes and build time of embree = 1", "the exact oracle", "hard cases, "})
    EXPECT_TRUE(holds(made().out, summary)) << summary << "\n" << made().out;
  for (const char* scene : {"wheels", "cloth"}) {
    EXPECT_TRUE(holds(read_file(path("page/tables/bench.txt")), std::string("== ") + scene));
    EXPECT_TRUE(holds(read_file(path("page/tables/error.txt")), std::string("== ") + scene));
  }
  EXPECT_TRUE(holds(read_file(path("page/tables/hard.txt")), "needles-1e4"));
}

TEST_F(ReportPage, HandsOnHowScenesAreMade) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  const std::string page = read_file(path("page/report.md"));
  for (const std::string command : {"bench", "error", "render"}) {
    const std::size_t begin = page.find("stbvh-ab " + command + " ");
    ASSERT_NE(begin, std::string::npos) << command << "\n" << page;
    const std::string line = page.substr(begin, page.find('\n', begin) - begin);
    EXPECT_TRUE(holds(line, kOfGltf)) << line;
  }
}

TEST_F(ReportPage, IsMadeAnewWithoutMeasuring) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  const Outcome again = stbvh_ab("report --from " + path("page") + " -o " + path("again"));
  EXPECT_EQ(again.exit_code, 0) << again.out;
  EXPECT_FALSE(holds(again.out, "embree")) << again.out;  // no tables
  EXPECT_EQ(read_file(path("again/index.html")), read_file(path("page/index.html")));
  EXPECT_EQ(read_file(path("again/report.md")), read_file(path("page/report.md")));
}

TEST_F(ReportPage, HoldsTheGalleryThatWasMeasured) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  EXPECT_FALSE(holds(read_file(path("page/report.md")), "The gallery"));
  fs::copy(path("page"), path("earlier"), fs::copy_options::recursive);
  write_file(path("earlier/records/gallery.json"),
             to_json(gallery_report(), Machine{}, "abc", "stbvh-ab gallery -o gallery"));
  const Outcome run = stbvh_ab("report --gallery --from " + path("earlier") + " -o " + path("with-gallery"));
  EXPECT_EQ(run.exit_code, 0) << run.out;
  EXPECT_EQ(
      problems(path("with-gallery"), "'The gallery' union kd4 'does not take b' '2.5 %' 'stbvh-ab gallery'"),
      "");
  for (const char* chart : {"gallery", "gallery-steps", "gallery-separate", "gallery-slices"})
    EXPECT_TRUE(fs::exists(path("with-gallery/charts/" + std::string(chart) + ".svg"))) << chart;
  // What the others found is theirs.
  EXPECT_EQ(read_file(path("with-gallery/charts/bytes.svg")), read_file(path("page/charts/bytes.svg")));
}

TEST_F(ReportPage, SaysThatThereAreNoChartsWithoutMatplotlib) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  fs::create_directories(path("without"));
  write_file(path("without/matplotlib.py"), "raise ImportError('none here')\n");
  setenv("PYTHONPATH", path("without").c_str(), 1);
  const Outcome run = stbvh_ab("report --from " + path("page") + " -o " + path("plain"));
  unsetenv("PYTHONPATH");
  EXPECT_EQ(run.exit_code, 0) << run.out;
  const std::string page = read_file(path("plain/index.html"));
  EXPECT_TRUE(holds(page, "no charts on this page"));
  EXPECT_FALSE(holds(page, "<svg"));
  EXPECT_EQ(problems(path("plain"), "embree stbvh wheels"), "");
}

TEST_F(ReportPage, RefusesBrokenRecordsBeforeMeasuring) {
  const auto with_bench = [&](const std::string& text) {
    fs::create_directories(path("records"));
    write_file(path("records/bench.json"), text);
    return "--from " + path("records") + " -o " + path("none");
  };
  expect_refused(with_bench("{\"machine\": {"), "not whole JSON");
  expect_refused(with_bench(""), "not whole JSON");
  expect_refused(with_bench("[1]"), "does not hold records");
  expect_refused(with_bench(R"({"machine": {}, "commit": "", "records": []})"), "no records");
  expect_refused("--from " + path("no-such") + " -o " + path("none"), "not a folder");
  fs::create_directories(path("empty"));
  expect_refused("--from " + path("empty") + " -o " + path("none"), "no records in");
}

TEST_F(ReportPage, RefusesToWriteWhereItCannot) {
  expect_refused("-o /proc/none", "Cannot make the directory");
  write_file(path("file"), "");
  expect_refused("-o " + path("file"), "Cannot make the directory");
}

}  // namespace
}  // namespace stbvh::harness
