/// What the Python scripts of harness/report/ read, write and say, whatever surrounds them.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "harness/report/json.h"
#include "tests/harness/bench_records.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

const std::string kProgram = STBVH_AB;

class ReportScripts : public TemporaryFolderTest {
 protected:
  void SetUp() override { write("bench.json", to_json(bench_report(), Machine{}, "abc")); }

  /// In the folder of the test; what waits for ever is ended.
  Outcome shell(const std::string& command) const {
    return run_command(fmt::format("exec 2>&1; cd {}; bash -c '{}'", folder.string(), command));
  }
  Outcome in_folder(const std::string& arguments, const std::string& before = "") const {
    return shell(fmt::format("{} timeout -s KILL 300 {} {}", before, kProgram, arguments));
  }
  Outcome results(const std::string& output) const { return in_folder("results bench.json -o " + output); }

  std::ptrdiff_t files() const { return std::distance(fs::directory_iterator(folder), {}); }
};

constexpr const char* kMarker = "<!-- made by stbvh-ab results: begin -->";

TEST_F(ReportScripts, ALoopOfLinksIsRefusedAndStays) {
  fs::create_symlink("b", folder / "a");
  fs::create_symlink("a", folder / "b");
  expect_refusal(results("a"), "Too many levels of symbolic links");
  EXPECT_TRUE(fs::is_symlink(folder / "a") && fs::is_symlink(folder / "b"));
  fs::create_directory(folder / "charts");
  fs::create_symlink("bytes.svg", folder / "charts" / "bytes.svg");
  const Outcome run = in_folder("charts bench.json -o charts");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.out.find("Too many levels of symbolic links"), std::string::npos) << run.out;
  EXPECT_TRUE(fs::is_symlink(folder / "charts" / "bytes.svg"));
}

TEST_F(ReportScripts, LinksToWhatIsNotThereYetStayLinks) {
  fs::create_directory(folder / "sub");
  fs::create_symlink("sub/later.md", folder / "link");
  EXPECT_EQ(results("link").exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_NE(read_file(folder / "sub" / "later.md").find(kMarker), std::string::npos);
}

TEST_F(ReportScripts, FoldersAreNotFiles) {
  fs::create_directory(folder / "there");
  for (const char* const name : {"none.md/", "there", "there/"})
    expect_refusal(results(name), "Is a directory");
  EXPECT_EQ(files(), 2);
}

TEST_F(ReportScripts, DevicesAndPipesAreWrittenToAndNotRead) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  const Outcome run = shell(fmt::format(
      "timeout 300 cat pipe >got & timeout -s KILL 300 {} results bench.json -o pipe; wait", kProgram));
  EXPECT_EQ(run.out, "pipe\n");
  EXPECT_NE(read_file(folder / "got").find(kMarker), std::string::npos);
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
  if (!make_device("null", Device::kNull) || !make_device("full", Device::kFull))
    GTEST_SKIP() << "only root may make device nodes";
  EXPECT_EQ(results("null").exit_code, 0);
  expect_refusal(results("full"), "No space left on device");
  EXPECT_TRUE(fs::is_character_file(folder / "null") && fs::is_character_file(folder / "full"));
}

TEST_F(ReportScripts, WhatIsOpenAlreadyIsWrittenToWhereItStands) {
  for (const char* const name : {"/dev/stdout", "/proc/self/fd/1", "link"}) {
    if (!fs::exists(folder / "link")) fs::create_symlink("/dev/fd/1", folder / "link");
    for (const char* const redirection : {">", ">>"}) {
      write("log", "");
      EXPECT_EQ(shell(fmt::format("( echo old; {} results bench.json -o {}; echo new ) {}log", kProgram, name,
                                  redirection))
                    .exit_code,
                0);
      const std::string log = read_file(folder / "log");
      EXPECT_TRUE(log.starts_with("old\n" + std::string(kMarker))) << log;
      EXPECT_TRUE(log.ends_with(fmt::format("\n{}\nnew\n", name))) << log;
    }
  }
}

TEST_F(ReportScripts, AnEarlierPageNeedNotBeUtf8) {
  ASSERT_EQ(results("page.md").exit_code, 0);
  const std::string page = read_file(folder / "page.md");
  write("page.md", "caf\xE9\n" + page);
  ASSERT_EQ(results("page.md").exit_code, 0);
  EXPECT_EQ(read_file(folder / "page.md"), "caf\xE9\n" + page);
}

TEST_F(ReportScripts, DoNotWaitForPipesThatNobodyWritesTo) {
  fs::create_directory(folder / "records");
  for (const char* const name : {"pipe", "records/bench.json"}) ASSERT_EQ(mkfifo(at(name).c_str(), 0600), 0);
  expect_refusal(in_folder("charts pipe -o charts"), "\"pipe\" is not a regular file");
  expect_refusal(in_folder("results pipe -o page.md"), "\"pipe\" is not a regular file");
  expect_refusal(in_folder("report --from records -o report"), "is not a regular file");
  fs::remove(folder / "records/bench.json");
  fs::copy(folder / "bench.json", folder / "records");
  fs::create_directory(folder / "records/images");
  ASSERT_EQ(mkfifo(at("records/images/a.png").c_str(), 0600), 0);
  expect_refusal(in_folder("report --from records -o report"), "a.png\" is not a regular file");
  // The shell's own pipes have who writes.
  const Outcome run = in_folder("results <(cat bench.json) -o page.md");
  EXPECT_EQ(run.exit_code, 0) << run.out;
}

TEST_F(ReportScripts, ChartsDoNotDependOnTheUsersSettings) {
  ASSERT_EQ(in_folder("charts bench.json -o plain").exit_code, 0);
  write("matplotlibrc", "nonsense\nfont.size: 20\n");
  fs::create_directory(folder / "config");
  fs::copy(folder / "matplotlibrc", folder / "config");
  for (const char* const before :
       {"MPLBACKEND=nonsense", "HOME=/proc", "MPLCONFIGDIR=config", "MATPLOTLIBRC=config/matplotlibrc"}) {
    fs::remove_all(folder / "charts");
    const Outcome run = in_folder("charts bench.json -o charts", before);
    EXPECT_EQ(run.exit_code, 0) << before;
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'),
              std::distance(fs::directory_iterator(folder / "charts"), {}))
        << before << run.out;
    EXPECT_EQ(read_file(folder / "charts/bytes.svg"), read_file(folder / "plain/bytes.svg")) << before;
  }
}

TEST_F(ReportScripts, ABrokenMatplotlibIsOneLine) {
  write("broken/matplotlib.py", "raise RuntimeError('not so')\n");
  const Outcome run = in_folder("charts bench.json -o charts", "PYTHONPATH=" + at("broken"));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "stbvh-ab: RuntimeError: not so.\n");
  write("broken/matplotlib.py", "raise ImportError('none\\n\\nhere')\n");
  expect_refusal(in_folder("charts bench.json -o charts", "PYTHONPATH=" + at("broken")), "(none here)");
}

TEST_F(ReportScripts, WithoutMemoryOrOpenFilesOneLine) {
  // The script alone: a sanitizer takes more.
  const std::string script = "exec timeout -s KILL 300 /usr/bin/python3 -B " STBVH_SOURCE_DIR
                             "/harness/report/charts.py bench.json -o charts";
  for (const char* const kilobytes : {"100000", "150000", "200000", "250000", "384000", "500000"}) {
    const Outcome run = shell(fmt::format("ulimit -v {}; {}", kilobytes, script));
    EXPECT_EQ(run.exit_code, 1) << kilobytes;
    EXPECT_EQ(run.out, "stbvh-ab: Not enough memory.\n") << kilobytes;
  }
  const Outcome run = shell(fmt::format("ulimit -n 10; exec {} charts bench.json -o charts", kProgram));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1) << run.out;
  EXPECT_NE(run.out.find("open files"), std::string::npos) << run.out;
}

TEST_F(ReportScripts, NamesNeedNotBeUtf8) {
  const Outcome run = in_folder("results bench.json -o $(printf \"\\xff.md\")", "LC_ALL=C.UTF-8");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "\\udcff.md\n");
  EXPECT_TRUE(fs::exists(folder / "\xFF.md"));
  expect_refusal(in_folder("charts $(printf \"\\xff.json\") -o charts"), ".json\": No such file");
}

}  // namespace
}  // namespace stbvh::harness
