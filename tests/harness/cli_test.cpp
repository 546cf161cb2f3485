#include <fmt/format.h>
#include <gmp.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/cli/wrong_answers.h"
#include "harness/program/closest_name.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/program.h"
#include "harness/program/usage_error.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

class Refused : public ::testing::TestWithParam<const char*> {};

TEST_P(Refused, WithOneLineAndExitCodeTwo) {
  expect_refusal(stbvh_ab(GetParam()), "");
}

INSTANTIATE_TEST_SUITE_P(
    CommandLines, Refused,
    ::testing::Values(
        "", "no-such-command", "bench --scenes", "bench --scenes no-such", "bench --scenes ''",
        "bench --scenes no-such.glb", "bench --scenes wheels --structures stbhv",
        "bench --scenes wheels --rays sideways", "bench --scenes wheels --scale 0",
        "bench --scenes wheels --scale -1", "bench --scenes wheels --scale nan",
        "bench --scenes wheels --scale inf", "bench --scenes wheels --scale 1e30",
        "bench --scenes wheels --scale abc", "bench --scenes wheels --repeats 0",
        "bench --scenes wheels --repeats -3", "bench --scenes wheels --repeats 1.5",
        "bench --scenes wheels --threads 0", "bench --scenes wheels --threads 100000",
        "bench --scenes wheels --threads 1,0", "bench --scenes wheels --threads 1,x",
        "error --scenes wheels --threads 1,1", "bench --scenes wheels --count 0",
        "bench --scenes wheels --count 1000000000000", "bench --scenes wheels --seed x",
        "bench --count=-18446744073709551615", "error --seed -1", "error --seed=-1", "hard --seed=-1",
        "error --seed 18446744073709551616", "hard --count=+5", "hard --count ' 5'",
        "hard --count=", "frames --frames 1,,2", "frames --frames 1,", "scaling --over steps --values 2,,3",
        "scaling --over steps --values ,3", "scaling --over steps --seed=-1", "bench --threads 1,,1",
        "hard --threads=-1", "gallery -o /tmp/none --growth=-1", "bench --scenes wheels --build-budget nan",
        "bench --scenes wheels --build-budget -1", "bench --scenes wheels --json /no/such/directory/a.json",
        "bench --scenes wheels --json /tmp", "error --scenes wheels --json /proc/a.json",
        "error --scenes wheels --no-such-option", "error --scenes wheels --repeats 3",
        "error --scenes a.glb --steps 0", "error --scenes a.glb --steps 130",
        "error --scenes a.glb --steps 2.5", "error --scenes a.glb --steps auto",
        "error --scenes a.glb --steps auto:0", "error --scenes a.glb --steps auto:1",
        "error --scenes a.glb --steps auto:nan", "error --scenes a.glb --steps keys:0",
        "error --scenes a.glb --steps keys:", "error --scenes a.glb --steps keyss",
        "error --resample-steps uneven", "error --resample-steps uneven:1", "error --resample-steps 1",
        "scaling --over steps --tolerance 1", "bench --resample-steps 4097", "bench --tolerance -1",
        "error --tolerance nan", "error --scenes a.glb --steps auto:1e-3x",
        "error --scenes a.glb --shutter-mode bounce", "error --scenes none.obj",
        "error --scenes /none/walk_%04d.obj", "error --scenes walk_%s.obj",
        "error --scenes a.glb --shutter 1", "error --scenes a.glb --shutter 1,0",
        "error --scenes a.glb --shutter 0,nan", "hard --families no-such", "hard --structures stbhv",
        "hard --count 0", "hard --threads 0", "hard --scenes wheels", "hard --rays bounce", "hard --seed x",
        "pareto --scenes wheels --plot a.png",
        "pareto --scenes wheels --json /tmp/a.json --plot /no/such/directory/a.png",
        "hard --families nan-rays --json /no/such/directory/a.json", "scaling", "scaling --over colours",
        "scaling --over steps --values 1,2", "scaling --over steps --values 4097",
        "scaling --over steps --values x", "scaling --over steps --scene crowd",
        "scaling --over triangles --values 0", "scaling --over triangles --scale 1",
        "scaling --over triangles --values 10000000 --scene barbarian-rotate",
        "scaling --over tolerance --tolerance 1e-3", "scaling --over tolerance --values 13",
        "scaling --over steps --resample-steps 9", "scaling --over threads --threads 1",
        "scaling --over threads --values 100000", "scaling --over steps --json /no/such/directory/a.json",
        "charts", "charts a.json", "charts -o /tmp", "charts a.json -o /tmp --format pdf",
        "charts /no/such.json -o /tmp", "compare", "compare a.exr", "compare /no/a.exr /no/b.exr", "truth",
        "truth -o /proc/none", "truth --scenes all -o /tmp", "truth --structures all -o /tmp",
        "truth --frozen-times 0 -o /tmp", "truth --spp 0 -o /tmp", "report", "report -o /proc/none",
        "report -o ''", "report --structures stbhv -o /tmp/none", "report --scenes no-such -o /tmp/none"));

// cli_test begins as the programs do: harness/program/program.cpp is in it.
TEST(ProgramDeathTest, WithoutMemoryForGmpEndsInOneLine) {
  const auto take_two_gigabytes = [] {
    const rlimit limit{std::size_t{1} << 30, std::size_t{1} << 30};
    setrlimit(RLIMIT_AS, &limit);
    mpz_t number;
    mpz_init2(number, mp_bitcnt_t{1} << 34);
  };
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need addresses without limit";
#endif
  EXPECT_EXIT(take_two_gigabytes(), testing::ExitedWithCode(1), "^cli_test: Not enough memory.\n$");
}

TEST(ProgramDeathTest, WithoutMemoryWhereNothingCatchesEndsInOneLine) {
  const auto no_memory = [] { throw std::bad_alloc(); };
  EXPECT_EXIT([](const auto& fail) noexcept { fail(); }(no_memory), testing::ExitedWithCode(1),
              "^cli_test: Not enough memory.\n$");
  EXPECT_EXIT(run_as_program(no_memory), testing::ExitedWithCode(1), "^cli_test: Not enough memory.\n$");
}

TEST(Program, EndsWithTheExitCodeOfWhatWentWrong) {
  EXPECT_EQ(run_as_program([] {}), 0);
  EXPECT_EQ(run_as_program([] { throw UsageError("no"); }), 2);
  EXPECT_EQ(run_as_program([] { throw std::runtime_error("no"); }), 1);
  EXPECT_EQ(run_as_program([] { std::filesystem::copy_file("/no/such", "/no/other"); }), 2);
  EXPECT_EQ(one_line("a\nb\x1b[31m\xC3\xBC"), "a?b?[31m\xC3\xBC");
}

TEST(Program, SaysWhatNamesOfAnyLengthDoNotHide) {
  std::string umlauts;
  for (int i = 0; i < 100'000; ++i) umlauts += "\xC3\xBC";
  for (const char* const before : {"", "a"}) {
    const std::string line = one_line(before + ("Cannot read \"" + umlauts) + "\": no such file.");
    EXPECT_LE(line.size(), 510u);
    EXPECT_TRUE(line.ends_with("\xC3\xBC\": no such file.")) << line;
    EXPECT_NE(line.find("\xC3\xBC...\xC3\xBC"), std::string::npos) << line;
  }
  const Outcome run = stbvh_ab("error --scenes " + std::string(100'000, 'x'));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_LT(run.out.size(), 600u);
}

TEST(Program, SaysThatAThreadCouldNotBeStarted) {
  testing::internal::CaptureStderr();
  const auto none = [] { throw std::system_error(EAGAIN, std::generic_category()); };
  EXPECT_EQ(run_as_program(none), 1);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("A thread could not be started: "),
            std::string::npos);
}

TEST(Program, SuggestsTheClosestName) {
  EXPECT_NE(stbvh_ab("bench --scenes wheals").out.find("did you mean \"wheels\""), std::string::npos);
  EXPECT_NE(stbvh_ab("bench --scenes wheels --structures stbhv").out.find("did you mean \"stbvh\""),
            std::string::npos);
}

TEST(Program, ListsAndHelps) {
  const Outcome list = stbvh_ab("list");
  EXPECT_EQ(list.exit_code, 0);
  for (const char* name : {"barbershop", "static-city", "stbvh-direct", "stbvh-direct-indexed",
                           "stbvh-direct-scalar", "lbvh-4v", "uniform", "stbvh-ab list --families"}) {
    EXPECT_NE(list.out.find(name), std::string::npos) << name;
  }
  EXPECT_LE(std::ranges::count(list.out, '\n'), 40) << "a screen";
  EXPECT_NE(stbvh_ab("list --families").out.find("closed-2k-8"), std::string::npos);
  EXPECT_EQ(stbvh_ab("--help").exit_code, 0);
  EXPECT_EQ(stbvh_ab("bench --help").exit_code, 0);
  EXPECT_EQ(stbvh_ab("hard --help").exit_code, 0);
  EXPECT_NE(stbvh_ab("--help").out.find("hard"), std::string::npos);
  const Outcome every_help = stbvh_ab("--help-all");
  EXPECT_EQ(every_help.exit_code, 0);
  EXPECT_NE(every_help.out.find("--build-budget"), std::string::npos);  // of bench
  const Outcome version = stbvh_ab("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_TRUE(version.out.starts_with("stbvh-ab (STBVH for Embree) ")) << version.out;
}

class Records : public TemporaryFolderTest {
 protected:
  nlohmann::json records(const std::string& arguments) const {
    const Outcome run = stbvh_ab(arguments + " --json " + at("records.json"));
    EXPECT_EQ(run.exit_code, 0) << run.out;
    return nlohmann::json::parse(read_file(at("records.json"))).at("records");
  }

  /// A folded strip of 20 quads that slides along itself, in two OBJ files.
  void write_sliding_strip() const {
    constexpr int kQuads = 20;
    for (const int step : {0, 1}) {
      std::string text;
      for (int i = 0; i <= kQuads; ++i)
        text += fmt::format("v {0} 0 {1}\nv {0} 9 {1}\n", i + 5 * step, i % 2);
      for (int i = 0; i < kQuads; ++i)
        text += fmt::format("f {} {} {} {}\n", 2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2);
      write(fmt::format("strip_{}.obj", step), text);
    }
  }
};

TEST_F(Records, OnAFullDiskAreReportedAfterTheTable) {
  if (!make_device("full", Device::kFull)) GTEST_SKIP() << "only root may make device nodes";
  const Outcome run =
      stbvh_ab("error --scenes wheels --scale 0.01 --structures embree --count 100 --rays primary --json " +
               at("full"));
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_NE(run.out.find("Cannot write to \"" + at("full") + "\""), std::string::npos) << run.out;
}

/// The log keeps what it has, and gets the tables, then the records.
TEST_F(Records, IntoStandardOutputStandBehindTheTables) {
  for (const char* const file : {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
    for (const char* const redirection : {">>", "1<>"}) {
      write("log", "my old log\n");
      const std::string log = std::string(redirection) == ">>" ? at("log") : at("new");
      fs::remove(at("new"));
      const Outcome run = run_command(fmt::format(
          "{} hard --families slivers-1e4 --structures stbvh-direct --count 20 --json {} {}{} 2>&1", STBVH_AB,
          file, redirection, log));
      EXPECT_EQ(run.exit_code, 0) << run.out;
      const std::string text = read_file(log);
      EXPECT_EQ(text.starts_with("my old log\n"), log == at("log")) << text;
      const std::size_t table = text.find("\nfamily"), records = text.find("\n{");
      ASSERT_NE(records, std::string::npos) << text;
      EXPECT_LT(table, records);
      EXPECT_TRUE(nlohmann::json::accept(text.substr(records))) << text;
    }
  }
}

TEST_F(Records, OfBenchHoldEveryStructureAndKind) {
  const auto all = records(
      "bench --scenes wheels,cloth --scale 0.02 --structures stbvh,lbvh --rays bounce,shadow --count 500 "
      "--repeats 2 --build-budget 0");
  // embree joins as the reference; against embree and lbvh: two kinds of rays, two sums of bytes, build time
  EXPECT_EQ(all.size(), 2u * (3u + 3u * 2u) + 3u * 2u * 5u);
  for (const auto& r : all) {
    if (r["kind"] != "speed") continue;
    EXPECT_GT(r["mrays_per_s"], 0.0);
    EXPECT_LE(r["mrays_per_s_min"], r["mrays_per_s"]);
    EXPECT_GE(r["mrays_per_s_max"], r["mrays_per_s"]);
    if (r["structure"] == "embree") {
      EXPECT_EQ(r["ratio_to_embree"], 1.0);
    }
  }
}

TEST_F(Records, OfBenchHoldEveryThreadCount) {
  if (usable_core_count() < 2) GTEST_SKIP() << "one core";
  const auto all = records(
      "bench --scenes wheels --scale 0.02 --structures stbvh --rays bounce --count 500 --repeats 2 "
      "--build-budget 0 --threads 1,2");
  ASSERT_EQ(all.size(), 2u + 2u * 2u);
  EXPECT_EQ(all[0]["threads"], 2);
  for (std::size_t i = 2; i < all.size(); ++i) {
    EXPECT_EQ(all[i]["threads"], i < 4 ? 1 : 2);
    EXPECT_EQ(all[i]["ratios_to_embree"].size(), 2u);
  }
}

TEST_F(Records, OfScalingHoldEveryStepCountAndStructure) {
  const auto all = records(
      "scaling --over steps --values 3,2,5 --scale 0.005 --structures stbvh-direct,lbvh --count 500 "
      "--repeats 2 "
      "--build-budget 0");
  ASSERT_EQ(all.size(), 3u * 3u);  // embree joins
  std::size_t segments = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& r = all[i];
    EXPECT_EQ(r["kind"], "scaling");
    EXPECT_EQ(r["over"], "steps");
    EXPECT_EQ(r["scene"], "cloth");
    EXPECT_EQ(r["value"], (std::vector{2, 3, 5}[i / 3]));
    EXPECT_EQ(r["structure"], (std::vector{"embree", "lbvh", "stbvh-direct"}[i % 3]));
    EXPECT_EQ(r["triangles"], all[0]["triangles"]);
    EXPECT_GT(r["structure_bytes"], 0);
    EXPECT_GT(r["build_s"], 0.0);
    for (const char* rays : {"bounce", "uniform"}) {
      EXPECT_GT(r[std::string(rays) + "_mrays_per_s"], 0.0);
      EXPECT_LE(r[std::string(rays) + "_mrays_per_s_min"], r[std::string(rays) + "_mrays_per_s_max"]);
    }
    if (i % 3 == 0) {
      EXPECT_GT(r["primitive_segments"], segments);
      segments = r["primitive_segments"];
    }
  }
}

TEST_F(Records, OfBuildsSayWhichStepsWereKept) {
  const std::string bench =
      "bench --scenes wheels --scale 0.01 --structures embree,stbvh,stbvh-direct --rays uniform --count 100 "
      "--repeats 1 --build-budget 0 --resample-steps 33 ";
  const auto builds = [&](const std::string& options) {
    std::map<std::string, nlohmann::json> found;
    for (const auto& r : records(bench + options)) {
      if (r["kind"] == "build") found[r["structure"]] = r;
    }
    return found;
  };
  auto exact = builds(""), coarse = builds("--tolerance 1e-2");
  const std::size_t given = exact["embree"]["steps"];
  EXPECT_EQ(exact["embree"]["steps_kept"], given);
  EXPECT_EQ(given % 33, 0u);
  for (const char* ours : {"stbvh", "stbvh-direct"}) {
    EXPECT_LT(exact[ours]["steps_kept"], given) << "the ground stands still";
    EXPECT_LT(coarse[ours]["steps_kept"], exact[ours]["steps_kept"]);
    EXPECT_LT(coarse[ours]["structure_bytes"], exact[ours]["structure_bytes"]);
    EXPECT_GT(coarse[ours]["max_deviation"], exact[ours]["max_deviation"]);
    EXPECT_LE(coarse[ours]["max_deviation"], coarse[ours]["tolerance"]);
  }
}

/// It asks for surfaces that stand elsewhere: how many rays that changes is a figure, not a failure.
TEST_F(Records, OfErrorsWithATolerance) {
  std::size_t wrong = 0;
  for (const auto& r :
       records("error --scenes wheels --scale 0.01 --structures stbvh-direct --rays uniform --count 3000 "
               "--resample-steps 33 --tolerance 3e-2")) {
    if (r["kind"] != "error") continue;
    for (const char* count : {"missed", "false_hits", "wrong_primitive"})
      wrong += r[count].get<std::size_t>();
  }
  EXPECT_GT(wrong, 0u);
}

/// Embree's structures are left out with a line that says why; what is left is measured and right.
TEST_F(Records, OfUnevenStepsAreOurs) {
  const std::string options =
      " --scenes wheels --scale 0.01 --structures embree,lbvh,stbvh --rays uniform,bounce --count 200 "
      "--resample-steps uneven:200";
  for (const std::string command : {"error", "bench --repeats 1 --build-budget 0"}) {
    std::size_t found = 0;
    for (const auto& r : records(command + options)) {
      if (r["kind"] == "summary") continue;
      EXPECT_EQ(r["structure"], "stbvh") << r;
      ++found;
    }
    EXPECT_GE(found, 2u) << command;
    const Outcome run = stbvh_ab(command + options);
    for (const char* name : {"embree", "lbvh"}) {
      EXPECT_NE(run.out.find(std::string(name) + " left out: Embree takes equidistant steps, 129 at most"),
                std::string::npos)
          << run.out;
    }
  }
}

/// Of a structure that is compared with nothing there is no speed.
TEST_F(Records, OfParetoHaveNoSpeedOverStepsThatEmbreeDoesNotTake) {
  const std::string pareto =
      "pareto --scenes wheels --scale 0.01 --structures stbvh-direct --repeats 1 --count 100 "
      "--resample-steps 130 --json " +
      at("records.json");
  const Outcome run = stbvh_ab(pareto);
  EXPECT_EQ(run.exit_code, 0) << run.out;
  const std::size_t row = run.out.rfind("\nstbvh-direct ");
  ASSERT_NE(row, std::string::npos) << run.out;
  EXPECT_NE(run.out.substr(row, 60).find(" - "), std::string::npos) << run.out;
  EXPECT_EQ(stbvh_ab(pareto + " --plot " + at("pareto.png")).exit_code, 2);
}

TEST(Program, ConvertRefusesStepsThatTheFormatDoesNotHave) {
  const Outcome run = stbvh_ab("convert wheels --scale 0.01 --resample-steps 130 -o /tmp/stbvh_none.xml");
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_NE(run.out.find("--resample-steps 129"), std::string::npos) << run.out;
}

TEST_F(Records, OfScalingOverTrianglesAreBuilds) {
  const auto all = records(
      "scaling --over triangles --values 2000,8000 --scene barbarian-rotate --structures embree,stbvh-direct "
      "--build-budget 0");
  ASSERT_EQ(all.size(), 4u);
  for (const auto& r : all) {
    const double asked = r["value"];
    EXPECT_NEAR(r["triangles"], asked, 0.1 * asked);
    EXPECT_GE(r["peak_bytes"], r["structure_bytes"]);
    EXPECT_FALSE(r.contains("bounce_mrays_per_s"));
  }
  EXPECT_EQ(all[3]["value"], 8000);
}

TEST_F(Records, OfScalingOverToleranceShrink) {
  const auto all = records(
      "scaling --over tolerance --values 6,2 --scene barbarian-rotate --scale 0.01 --resample-steps 33 "
      "--structures stbvh-direct,lbvh --count 500 --repeats 2 --build-budget 0");
  std::map<std::string, std::map<int, nlohmann::json>> found;
  for (const auto& r : all) {
    EXPECT_EQ(r["over"], "tolerance");
    found[r["structure"]][r["value"]] = r;
  }
  EXPECT_EQ(found["lbvh"].size(), 1u) << "which leaves out no steps";
  const auto &coarse = found["stbvh-direct"][2], &fine = found["stbvh-direct"][6];
  EXPECT_LT(coarse["structure_bytes"], fine["structure_bytes"]);
  EXPECT_LT(coarse["steps_kept"], fine["steps_kept"]);
  EXPECT_GT(coarse["tolerance"], fine["tolerance"]);
  EXPECT_LE(coarse["max_deviation"], coarse["tolerance"]);
  EXPECT_GT(coarse["max_deviation"], fine["max_deviation"]);
  EXPECT_EQ(found["embree"][2]["structure_bytes"], found["embree"][6]["structure_bytes"]);
}

TEST_F(Records, OfScalingOverThreadsHoldEachCount) {
  const auto all =
      records("scaling --over threads --scale 0.005 --structures embree --count 500 --repeats 2");
  ASSERT_EQ(all.size(), usable_core_count());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i]["threads"], i + 1);
    EXPECT_EQ(all[i]["value"], i + 1);
  }
}

TEST(Program, ScalingLeavesOutSlowBuilds) {
  const Outcome run = stbvh_ab(
      "scaling --over triangles --values 1000,2000,4000 --structures embree,stbvh-direct --build-budget "
      "1e-9");
  EXPECT_EQ(run.exit_code, 0) << run.out;
  for (const char* name : {"embree", "stbvh-direct"})
    EXPECT_NE(run.out.find(std::string(name) + " left out of larger scenes"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("with 2000 triangles"), std::string::npos) << run.out;
}

TEST_F(Records, OfParetoAreAPointForEachStructure) {
  const auto all = records(
      "pareto --scenes wheels --scale 0.02 --structures embree,stbvh-direct,stbvh-direct-fast --repeats 2 "
      "--count 500");
  std::vector<nlohmann::json> points;
  std::copy_if(all.begin(), all.end(), std::back_inserter(points),
               [](const auto& r) { return r["kind"] == "pareto"; });
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[0]["structure"], "embree");
  EXPECT_EQ(points[0]["ratio_to_embree"], 1.0);
  EXPECT_GT(points[0]["leaks"], 0);
  EXPECT_EQ(points[1]["structure"], "stbvh-direct");
  EXPECT_EQ(points[1]["leaks"], 0);
  EXPECT_EQ(points[1]["aimed"], 2500);
  EXPECT_NEAR(points[1]["leak_rate_bound_95"], 3.0 / 2500, 1e-12);
  EXPECT_LT(points[1]["t_error_rel_p99"], 1e-6);
  EXPECT_EQ(points[2]["structure"], "stbvh-direct-fast");
  EXPECT_GT(points[2]["leaks"], 0);
}

TEST_F(Records, OfErrorFindNoneInOurs) {
  const auto all = records("error --scenes wheels --scale 0.05 --structures stbvh,stbvh-direct --count 2000");
  ASSERT_EQ(all.size(), 8u);
  for (const auto& r : all) {
    EXPECT_EQ(r["traced"], 2000);
    EXPECT_EQ(r["missed"], 0);
    EXPECT_EQ(r["false_hits"], 0);
    EXPECT_EQ(r["wrong_primitive"], 0);
  }
}

TEST_F(Records, OfErrorNameTheFilesFacesBesidePrimitives) {
  write_sliding_strip();
  // Two trees that stand still are wrong for all times but two.
  std::size_t hits = 0;
  for (const auto& record : records("error --scenes " + at("strip_%d.obj") +
                                    " --structures separate-2 --rays uniform,shadow --count 200")) {
    const bool is_shadow = record.at("rays") == "shadow";
    EXPECT_FALSE(record.at("differences").empty());
    for (const auto& difference : record.at("differences")) {
      EXPECT_LT(difference.at("ray"), record.at("traced"));
      EXPECT_EQ(difference.at("tfar").is_number(), is_shadow);  // infinite for the others
      for (const auto& answer : {difference.at("reported"), difference.at("exact")}) {
        if (answer.empty()) continue;  // nothing, or something
        EXPECT_FALSE(is_shadow);
        EXPECT_EQ(answer.at("face"), answer.at("primitive").get<int>() / 2);
        EXPECT_EQ(answer.at("mesh"), 0);
        EXPECT_GT(answer.at("t"), 0);
        ++hits;
      }
    }
  }
  EXPECT_GT(hits, 0u);
}

TEST_F(Records, OfHardHoldEveryFamilyAndStructure) {
  const auto all = records(
      "hard --families closed-2k-2,needles-1e4,leaving-8-ulps,nan-rays,too-many-steps "
      "--structures stbvh-direct,stbvh,embree --count 500 --seed 3");
  ASSERT_EQ(all.size(), 3u * 3u + 1u + 2u);  // Embree is not asked with NaN, nor with so many steps
  for (const auto& r : all) {
    EXPECT_EQ(r["kind"], "hard");
    EXPECT_GT(r["traced"], 0);
    EXPECT_EQ(r["leaks"].is_null(), r["family"] != "closed-2k-2");
    EXPECT_EQ(r["self_hits"].is_null(), r["family"] != "leaving-8-ulps");
    if (r["structure"] == "embree") continue;
    for (const char* count : {"missed", "false_hits", "wrong_primitive", "any_hit_wrong"}) {
      EXPECT_EQ(r[count], 0) << r["family"] << " " << count;
    }
  }
}

TEST_F(Records, OfHardDoNotDependOnThreads) {
  const std::string arguments = "hard --families half-turn --structures stbvh-direct --count 1000 --threads ";
  const auto one = records(arguments + "1");
  EXPECT_EQ(one, records(arguments + std::to_string(usable_core_count())));
}

TEST(WrongAnswers, LeaksOfOursAreAnError) {
  const HardResult others{.family = "f", .structure = "embree-robust", .leaks = 5, .missed = 3};
  const HardResult rounding{.family = "f", .structure = "stbvh", .leaks = 0, .ties = 7, .within_rounding = 9};
  EXPECT_NO_THROW(require_right_answers(std::vector{others, rounding}));
  HardResult leaking{.family = "f", .structure = "stbvh-direct-scalar", .leaks = 1};
  EXPECT_THROW(require_right_answers(std::vector{others, leaking}), WrongAnswers);
  for (auto count : {&HardResult::missed, &HardResult::false_hits, &HardResult::wrong_primitive,
                     &HardResult::any_hit_wrong}) {
    HardResult wrong{.family = "f", .structure = "stbvh"};
    wrong.*count = 1;
    EXPECT_THROW(require_right_answers(std::vector{wrong}), WrongAnswers);
  }
}

TEST(WrongAnswers, OfOursAreAnErrorThoseOfOthersAreFigures) {
  const ErrorResult others{.scene = "s", .structure = "embree", .rays = "bounce", .missed = 3};
  const ErrorResult rounding{
      .scene = "s", .structure = "stbvh", .rays = "bounce", .ties = 7, .within_rounding = 9};
  EXPECT_NO_THROW(require_right_answers(std::span<const ErrorResult>{}));
  EXPECT_NO_THROW(require_right_answers(std::vector{others, rounding}));
  for (const char* structure : {"stbvh", "stbvh-direct", "stbvh-direct-indexed"}) {
    for (auto count : {&ErrorResult::missed, &ErrorResult::false_hits, &ErrorResult::wrong_primitive}) {
      ErrorResult ours{.scene = "s", .structure = structure, .rays = "shadow"};
      ours.*count = 1;
      EXPECT_THROW(require_right_answers(std::vector{others, ours}), WrongAnswers) << structure;
    }
  }
  try {
    require_right_answers(std::vector{
        others,
        ErrorResult{.scene = "s", .structure = "stbvh", .rays = "shadow", .missed = 2, .false_hits = 1}});
    FAIL();
  } catch (const WrongAnswers& wrong) {
    EXPECT_STREQ(
        wrong.what(),
        "3 wrong answers of our structures (stbvh on s, shadow: 2 missed, 1 false, 0 wrong primitive).");
  }
  EXPECT_NO_THROW(require_right_answers(std::vector<ErrorResult>{
      {.scene = "s", .structure = "stbvh", .rays = "shadow", .missed = 2, .has_tolerance = true}}));
  std::vector<ErrorResult> many;
  for (std::size_t missed = 1; missed <= 5; ++missed)
    many.push_back({.scene = "s", .structure = "stbvh", .rays = std::to_string(missed), .missed = missed});
  try {
    require_right_answers(many);
    FAIL();
  } catch (const WrongAnswers& wrong) {
    EXPECT_STREQ(wrong.what(),
                 "15 wrong answers of our structures (stbvh on s, 5: 5 missed, 0 false, 0 wrong primitive; "
                 "stbvh on s, 4: 4 missed, 0 false, 0 wrong primitive; stbvh on s, 3: 3 missed, 0 false, 0 "
                 "wrong primitive; and in 2 places more).");
  }
}

TEST(ClosestName, FewestEdits) {
  const std::string_view names[]{"embree", "lbvh", "stbvh"};
  EXPECT_EQ(closest_name("embre", names), "embree");
  EXPECT_EQ(closest_name("lbhv", names), "lbvh");
  EXPECT_EQ(closest_name("st", names), "stbvh");
}

}  // namespace
}  // namespace stbvh::harness
