/// `stbvh-ab gallery` on tiny scenes, and what it is made of.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/cli/gallery_scene.h"
#include "harness/cli/gallery_slices.h"
#include "harness/cli/turning_bar.h"
#include "harness/cli/wrong_answers.h"
#include "harness/program/program.h"
#include "harness/report/gallery_table.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/gallery_records.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

constexpr const char* kReferences[]{"embree", "lbvh", "stbvh-direct", "stbvh-direct-scalar"};

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const std::string_view name : gallery_names()) names.emplace_back(name);
  names.insert(names.end(), std::begin(kReferences), std::end(kReferences));
  return names;
}

bool has_row(const std::string& text, const std::string& structure) {
  return text.find("\n" + structure + " ") != std::string::npos;
}

/// One run for all tests.
class GalleryCommand : public SharedFolderTest {
 protected:
  static const Outcome& made() {
    static const Outcome outcome = stbvh_ab(
        "gallery --scenes wheels,cloth --scale 0.01 --count 200 --repeats 1 --growth 300 -o " + path("out"));
    return outcome;
  }
  static std::vector<nlohmann::json> records(const std::string& kind) {
    std::vector<nlohmann::json> found;
    const auto all = nlohmann::json::parse(read_file(path("out/gallery.json"))).at("records");
    for (const auto& r : all) {
      if (r["kind"] == kind) found.push_back(r);
    }
    return found;
  }
};

TEST_F(GalleryCommand, ShowsEveryStructureOnAScreen) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  for (const std::string& name : all_names()) EXPECT_TRUE(has_row(made().out, name)) << name << made().out;
  for (const char* file : {"wheels.txt", "cloth.txt", "gallery.txt"}) {
    const std::string table = read_file(path("out/" + std::string(file)));
    for (const std::string& name : all_names()) EXPECT_TRUE(has_row(table, name)) << file << " " << name;
  }
}

TEST_F(GalleryCommand, RecordsWhatEachIsAndDoes) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  const auto results = records("gallery");
  ASSERT_EQ(results.size(), 2 * all_names().size());
  for (const auto& r : results) {
    const std::string name = r["structure"];
    EXPECT_EQ(r["is_exact"] == 1, is_exact(name));
    EXPECT_EQ(r["compared_with"], is_scalar(name) ? "stbvh-direct-scalar" : "stbvh-direct");
    if (!r["obstacle"].is_null()) continue;
    EXPECT_EQ(r["traced"], 4 * 200) << name;
    if (is_exact(name)) {
      EXPECT_EQ(r["wrong"], 0) << name;
    }
    if (name == "union" || name == "stbvh-direct") {
      EXPECT_GT(r["nodes_per_ray"], 0.0);
      EXPECT_GT(r["leaves_per_ray"], 0.0);
    }
  }
  std::map<std::string, std::size_t> scalings;
  for (const auto& r : records("scaling")) {
    if (r["structure"] == "union") ++scalings[r["over"]];
    EXPECT_GT(r["bounce_mrays_per_s"], 0.0);
  }
  EXPECT_EQ(scalings["steps"], 8u);
  EXPECT_EQ(scalings["quarter turns"], 9u);
  for (const auto& r : records("summary")) {
    if (r["structure"] == r["reference"]) {
      EXPECT_EQ(r["mean_ratio"], 1.0) << r;
    }
  }
}

TEST_F(GalleryCommand, DrawsItsPictures) {
  ASSERT_EQ(made().exit_code, 0) << made().out;
  for (const char* name : {"gallery", "gallery-steps", "gallery-quarter-turns", "gallery-slices"}) {
    EXPECT_TRUE(read_file(path("out/" + std::string(name) + ".png")).starts_with("\x89PNG")) << name;
    EXPECT_NE(made().out.find(std::string(name) + ".png\n"), std::string::npos) << made().out;
  }
}

TEST_F(GalleryCommand, SaysWhatAMethodDoesNotTake) {
  const Outcome run = stbvh_ab(
      "gallery --scenes wheels --scale 0.01 --count 50 --repeats 1 --growth 0 --no-pictures --structures "
      "union,lbvh --resample-steps uneven:5 -o " +
      path("uneven"));
  EXPECT_EQ(run.exit_code, 0) << run.out;
  EXPECT_NE(run.out.find("lbvh does not take wheels: Embree takes equidistant steps"), std::string::npos)
      << run.out;
  EXPECT_TRUE(has_row(run.out, "union")) << run.out;
  EXPECT_FALSE(fs::exists(path("uneven/gallery.png")));
}

TEST_F(GalleryCommand, RefusesWhatCannotBe) {
  const std::string tiny = "gallery --scenes wheels --scale 0.01 --count 50 --repeats 1 --growth 0 ";
  expect_refusal(stbvh_ab("gallery --scenes wheels"), "--output is required");
  expect_refusal(stbvh_ab(tiny + "-o /proc/none"), "Cannot make the directory");
  expect_refusal(stbvh_ab(tiny + "-o " + path("none") + " --structures onion"), "onion");
  expect_refusal(stbvh_ab(tiny + "-o " + path("none") + " --scenes no-such"), "no-such");
  expect_refusal(stbvh_ab("gallery --growth 1000000000 -o " + path("none")), "--growth");
  expect_refusal(stbvh_ab(tiny + "-o " + path("none") + " --json /proc/a.json"), "Cannot write");
}

TEST(GalleryCommands, AreListed) {
  const Outcome list = stbvh_ab("list --gallery");
  EXPECT_EQ(list.exit_code, 0);
  for (const std::string_view name : gallery_names())
    EXPECT_NE(list.out.find(std::string(name) + " "), std::string::npos) << list.out;
}

/// Answers as another one, but that it loses every tenth hit.
class Loser final : public StructureUnderTest {
 public:
  Loser(const Scene& scene) : right_(build_structure("stbvh-direct", scene, 1)) {}

  const BuildRecord& build_record() const override { return right_->build_record(); }
  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override {
    right_->intersect(rays, hits);
    lose(rays, hits);
  }
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override {
    right_->occluded(rays, hits);
    lose(rays, hits);
  }
  bool intersect_one(const Ray& ray, Hit& hit) const override { return right_->intersect_one(ray, hit); }
  bool occluded_one(const Ray& ray) const override { return right_->occluded_one(ray); }

 private:
  static void lose(std::span<const Ray> rays, std::span<HitRecord> hits) {
    for (std::size_t i = 0; i < hits.size(); i += 10) hits[i] = {rays[i].tfar, kInvalidId, kInvalidId};
  }

  std::unique_ptr<StructureUnderTest> right_;
};

struct Asked {
  std::vector<GalleryResult> results;
  std::vector<ErrorResult> errors;
};

Asked ask(const std::string& name, const Scene& scene, const StructureUnderTest& structure) {
  Progress progress;
  PinnedThreads threads(1);
  RayOptions rays;
  rays.count = 200;
  const std::vector<RaySet> sets = make_ray_sets(scene, rays, 1, 1, progress);
  GalleryScene gallery(scene, threads, progress);
  gallery.on_built(name, structure, sets);
  gallery.on_built(name, structure, sets);  // as that which ratios refer to may be
  return {gallery.results({name}), gallery.errors()};
}

TEST(GalleryAnswers, ThatAreWrongEndTheProgramWithExitCodeOne) {
  const Scene scene = make_turning_bar(0.5, 9, 500);
  const Asked wrong = ask("union", scene, Loser(scene));
  ASSERT_EQ(wrong.results.size(), 1u);
  EXPECT_EQ(wrong.errors.size(), 4u);
  EXPECT_EQ(wrong.results[0].traced, 4u * 200u);
  EXPECT_GT(wrong.results[0].wrong, 20u);
  EXPECT_EQ(run_as_program([&] { require_right_answers(wrong.errors); }), 1);
  EXPECT_NE(gallery_table(wrong.results, {}).find(std::to_string(wrong.results[0].wrong) + " !"),
            std::string::npos);
  // Of a structure that promises nothing they are a figure.
  const Asked others = ask("embree", scene, Loser(scene));
  EXPECT_EQ(others.results[0].wrong, wrong.results[0].wrong);
  EXPECT_EQ(run_as_program([&] { require_right_answers(others.errors); }), 0);
}

TEST(GalleryAnswers, ThatAreRightAreCounted) {
  const Scene scene = make_turning_bar(0.5, 9, 500);
  const Asked asked = ask("union", scene, *build_structure("union", scene, 1));
  EXPECT_EQ(asked.results[0].wrong, 0u);
  ASSERT_TRUE(asked.results[0].visits);
  EXPECT_GT(asked.results[0].visits->nodes, 1);
  EXPECT_GT(asked.results[0].visits->triangle_tests, 0);
}

TEST(GalleryFacts, SayWhatStepsAreTaken) {
  EXPECT_EQ(steps_taken("union"), "any");
  EXPECT_EQ(steps_taken("stbvh-direct"), "any");
  EXPECT_EQ(steps_taken("embree"), "129, even");
  EXPECT_EQ(compared_with("linear"), "stbvh-direct");
  EXPECT_EQ(compared_with("stbvh-direct-scalar"), "stbvh-direct-scalar");
}

TEST(GalleryTable, HoldsRatiosVisitsErrorsAndObstacles) {
  const Report report = gallery_report();
  const std::string table = gallery_table(report.galleries, report.summaries);
  for (const char* part : {"the gallery, 2 scenes", "\nkd4 * ", "17         1 of 2 scenes\n", "2.5 %",
                           "kd4 does not take b: it has too many steps.", "\nstbvh-direct  "})
    EXPECT_NE(table.find(part), std::string::npos) << part << table;
  const std::size_t row = table.find("\nunion ");
  // 1 of 2.25, in both repeats; its own nodes and leaves
  EXPECT_NE(table.substr(row, table.find('\n', row + 1) - row).find("0.44 (0.44-0.44)   10.0    2.0"),
            std::string::npos)
      << table;
  EXPECT_EQ(gallery_table({}, {}), "");
}

TEST(TurningBar, TurnsByAsManyTurns) {
  for (const std::size_t triangles : {96u, 1'000u, 20'000u}) {
    const Scene scene = make_turning_bar(0.25, 3, triangles);
    EXPECT_NEAR(static_cast<double>(scene.triangle_count()), static_cast<double>(triangles),
                0.1 * static_cast<double>(triangles));
    const Mesh& bar = scene.meshes.front();
    ASSERT_EQ(bar.steps.size(), 3u);
    for (std::size_t i = 0; i < bar.steps[0].size(); ++i) {  // by a right angle
      EXPECT_NEAR(bar.steps[2][i].x, -bar.steps[0][i].y, 1e-6f);
      EXPECT_NEAR(bar.steps[2][i].y, bar.steps[0][i].x, 1e-6f);
    }
    for (const std::uint32_t index : bar.indices) ASSERT_LT(index, bar.steps[0].size());
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;  // closed, all faces turned alike
    for (std::size_t i = 0; i < bar.indices.size(); i += 3) {
      for (std::size_t c = 0; c < 3; ++c) ++edges[{bar.indices[i + c], bar.indices[i + (c + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
  }
}

TEST(GallerySlices, HoldTheTriangles) {
  Progress progress;
  std::map<double, std::vector<std::vector<SliceResult::Point>>> triangles;
  std::size_t shown = 0;
  for (const SliceResult& slice : slices_of(all_names(), progress)) {
    if (slice.structure.empty()) triangles[slice.time] = slice.shapes;
    if (slice.structure.empty() || !is_exact(slice.structure)) continue;
    ++shown;
    for (const auto& triangle : triangles.at(slice.time)) {
      const auto holds = [](const auto& shape, const SliceResult::Point& p) {
        return std::ranges::all_of(std::array{0u, 1u}, [&](std::size_t axis) {
          const auto at = [=](const SliceResult::Point& q) { return q[axis]; };
          return at(*std::ranges::min_element(shape, {}, at)) <= p[axis] + 1e-5f &&
                 at(*std::ranges::max_element(shape, {}, at)) >= p[axis] - 1e-5f;
        });
      };
      // Each in the rectangle round one of the bounds; where space is split, each of its corners.
      const auto holds_all = [&](const auto& shape) {
        return std::ranges::all_of(triangle, [&](const auto& p) { return holds(shape, p); });
      };
      const auto is_anywhere = [&](const SliceResult::Point& p) {
        return std::ranges::any_of(slice.shapes, [&](const auto& shape) { return holds(shape, p); });
      };
      const bool splits_space = slice.structure == "kd4" || slice.structure == "msbvh";
      EXPECT_TRUE(splits_space ? std::ranges::all_of(triangle, is_anywhere)
                               : std::ranges::any_of(slice.shapes, holds_all))
          << slice.structure << " at " << slice.time;
    }
  }
  EXPECT_GE(shown, 3u * 5u) << "union, linear and stbvh-direct at each time";
}

}  // namespace
}  // namespace stbvh::harness
