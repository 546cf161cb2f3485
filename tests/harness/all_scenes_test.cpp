/// Every structure on every scene there is, small: the built-in ones, our own glTF files, the shared assets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "harness/oracle/judge.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/gltf/gltf.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/vec3.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/trace_all.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(STBVH_SOURCE_DIR) / "data";
const fs::path kAssets = fs::path(STBVH_SOURCE_DIR) / "../shared/assets";
constexpr std::size_t kRaysOfEachKind = 300;
constexpr double kScale = 0.01;
constexpr std::size_t kSteps = 9;

struct JudgedRays {
  RaySet rays;
  std::vector<OracleAnswer> answers;
};

std::vector<JudgedRays> judged_rays(const Scene& scene, const Oracle& oracle) {
  const auto reference = build_structure("embree-robust", scene, 0);
  std::vector<JudgedRays> sets;
  for (const RayKind kind : ray_kinds()) {
    RaySet rays = make_rays(kind, scene, *reference, kRaysOfEachKind, 3);
    EXPECT_EQ(rays.rays.size(), kRaysOfEachKind) << ray_kind_name(kind);
    std::vector<OracleAnswer> answers = oracle.answers(rays.rays);
    sets.push_back({std::move(rays), std::move(answers)});
  }
  return sets;
}

/// Ours must agree with the oracle but for rounding; the others may miss at edges, which is their known
/// error.
void expect_answers(std::string_view structure, const JudgedRays& set, const ErrorCounts& counts) {
  const std::string where = std::string(structure) + ", " + std::string(ray_kind_name(set.rays.kind));
  const std::size_t wrong = counts.missed + counts.false_hits + counts.wrong_primitive;
  if (is_exact(structure)) {
    EXPECT_EQ(counts.missed, 0u) << where;
    EXPECT_EQ(counts.false_hits, 0u) << where;
    EXPECT_EQ(counts.wrong_primitive, 0u) << where;
  } else {
    EXPECT_LE(wrong, counts.traced / 100) << where;
  }
}

void expect_all_structures_agree(const Scene& scene) {
  const Box3f box = scene.bounds();
  const double diagonal =
      length(Vec3{box.upper.x, box.upper.y, box.upper.z} - Vec3{box.lower.x, box.lower.y, box.lower.z});
  const Oracle oracle(scene);
  const std::vector<JudgedRays> sets = judged_rays(scene, oracle);
  for (const std::string_view name : structure_names()) {
    const auto structure = build_structure(name, scene, 0);
    std::size_t hits = 0;
    for (const JudgedRays& set : sets) {
      const ErrorCounts counts =
          judge(oracle, diagonal, set.rays, set.answers, trace_all(*structure, set.rays));
      expect_answers(name, set, counts);
      hits += counts.oracle_hits;
    }
    EXPECT_GT(hits, kRaysOfEachKind / 2) << "the rays see next to nothing";
  }
}

/// A name that GoogleTest takes.
std::string test_name(std::string_view text) {
  std::string name(text);
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

std::vector<fs::path> glb_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code missing;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, missing)) {
    if (entry.path().extension() == ".glb") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string file_test_name(const testing::TestParamInfo<fs::path>& info) {
  return test_name(info.param.stem().string());
}

class BuiltInScene : public testing::TestWithParam<ProceduralScene> {};

TEST_P(BuiltInScene, AllStructuresAgree) {
  expect_all_structures_agree(GetParam().make(kScale, 1));
}

INSTANTIATE_TEST_SUITE_P(AllScenes, BuiltInScene,
                         testing::ValuesIn(procedural_scenes().begin(), procedural_scenes().end()),
                         [](const auto& test) { return test_name(test.param.name); });

class OwnFile : public testing::TestWithParam<fs::path> {};

TEST_P(OwnFile, AllStructuresAgree) {
  expect_all_structures_agree(load_gltf(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(AllScenes, OwnFile, testing::ValuesIn(glb_files(kData)), file_test_name);

// One test over the whole folder: which files it has is known when the test runs, not when it is built.
TEST(SharedAssets, AllStructuresAgree) {
  const std::vector<fs::path> files = glb_files(kAssets);
  if (files.empty()) GTEST_SKIP() << "There are no .glb files in " << kAssets << ".";
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.filename().string());
    expect_all_structures_agree(load_gltf(file, {.clip = "", .shutter = {}, .steps = kSteps}));
  }
}

}  // namespace
}  // namespace stbvh::harness
