// USD and Alembic files, through the libraries that read them: skipped where their Python cannot be made.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "harness/images/exr_file.h"
#include "harness/scenes/shots/shot.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/shot_files.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

/// Positions at 50 times, against the libraries' own evaluation; `shutter`, in seconds, of Alembic files
/// alone.
void expect_true_positions(const std::string& python, const fs::path& folder, const fs::path& file,
                           const std::string& shutter = "") {
  const Outcome run = run_command(fmt::format(
      "exec 7>{0}/handover && {1} -B {2}/read_shot.py {6} -- {3} 7 && {4} -B {5}/tests/harness/shot_truth.py "
      "{3} {0}/handover {7} 2>&1 | tail -1",
      folder.string(), "/usr/bin/python3", kScripts, in_quotes(file), python, kSource,
      shutter.empty() ? "" : fmt::format("--shutter={}", shutter), shutter));
  double share = 1;
  int meshes = 0;
  ASSERT_EQ(std::sscanf(run.out.c_str(), "%lf %d", &share, &meshes), 2) << file << ": " << run.out;
  EXPECT_LT(share, 2e-6) << file;
  EXPECT_GT(meshes, 0) << file;
}

TEST_F(ShotsTest, PositionsAreThoseOfUsdCore) {
  for (const char* name : {"turning_bar", "nested_instances", "blend_shape", "velocities", "tumbling_puppet"})
    expect_true_positions(python_, folder, data(fmt::format("{}.usda", name)));
}

TEST_F(ShotsTest, PositionsOfOthersFilesAreThoseOfTheLibraries) {
  const fs::path shots = shared_shots();
  if (shots.empty()) GTEST_SKIP() << "../shared is not there";
  for (const fs::path& file : files_in(shots)) {
    expect_true_positions(python_, folder, file);
    // Of a single sample that has velocities, too.
    if (file.extension() == ".abc") expect_true_positions(python_, folder, file, "0.03,0.17");
  }
}

TEST_F(ShotsTest, StepsAreTheFilesOwnAndUneven) {
  const Scene scene = load(data("velocities.usda"));
  const Mesh* const thrown = find_mesh(scene, "/Thrown");
  ASSERT_NE(thrown, nullptr);
  EXPECT_TRUE(thrown->has_step_times());
  EXPECT_EQ(thrown->motion_range().begin, 0);
  EXPECT_EQ(thrown->motion_range().end, 1);
  // Of each sample a mesh with its own faces.
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Splash", &Mesh::name), 3);
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Crumble", &Mesh::name), 2);
  EXPECT_TRUE(is_warned_of("no velocities: /Crumble")) << warnings.size();
  EXPECT_TRUE(is_warned_of("corners do not add up: /Broken"));
  EXPECT_EQ(warnings.size(), 2u);
}

TEST_F(ShotsTest, VelocitiesReplaceInterpolation) {
  const Scene scene = load(data("velocities.usda"));
  const Mesh* const splash = find_mesh(scene, "/Splash");
  ASSERT_NE(splash, nullptr);
  ASSERT_EQ(splash->steps.size(), 2u);
  EXPECT_EQ(splash->steps[0][0].z, 0);
  EXPECT_NEAR(splash->steps[1][0].z, 0.01 * 6 / 24, 1e-8);  // a frame later; USD is in centimeters
}

TEST_F(ShotsTest, FacesKeepTheirNumbers) {
  const Scene scene = load(data("turning_bar.usda"));
  const Mesh* const bar = find_mesh(scene, "/Axle/Bar");
  ASSERT_NE(bar, nullptr);
  const std::vector<std::uint32_t> expected{0, 0, 0, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6};
  EXPECT_EQ(bar->faces, expected);
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Axle/Plate", &Mesh::name), 2);  // it is hidden in between
  EXPECT_EQ(scene.camera_steps.size(), 129u);
  EXPECT_EQ(bar->material.color.x, 0.8f);
}

TEST_F(ShotsTest, PicturesHaveTheFilesFaces) {
  const Outcome run =
      stbvh_ab(fmt::format("render --scenes {} --structures stbvh-direct --size 64x36 --spp 1 -o {}",
                           data("turning_bar.usda").string(), at("bar.exr")));
  ASSERT_EQ(run.exit_code, 0) << run.out;
  const Scene scene = load(data("turning_bar.usda"));
  const LayeredImage image = read_exr(at("bar.exr"));
  ASSERT_EQ(image.id_channels.size(), 3u);
  const auto values = [&](const std::string& name) {
    return std::ranges::find(image.id_channels, name, &IdChannel::name)->values;
  };
  const auto meshes = values("mesh.id"), triangles = values("primitive.id"), faces = values("face.id");
  std::size_t others = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const bool is_hit = meshes[i] < scene.meshes.size();
    EXPECT_EQ(faces[i], is_hit ? scene.meshes[meshes[i]].face_of(triangles[i]) : triangles[i]);
    others += faces[i] != triangles[i] ? 1u : 0u;
  }
  EXPECT_GT(others, 0u);
}

/// The file that the script writes must not get the number of a stream.
TEST_F(ShotsTest, AreReadWithClosedStreamsToo) {
  for (const char* streams : {"<&-", "2>&-", "<&- 2>&-"}) {
    const Outcome run = run_command(fmt::format("{} convert {} --resample-steps 9 -o {} {}", STBVH_AB,
                                                data("turning_bar.usda").string(), at("bar.xml"), streams));
    EXPECT_EQ(run.exit_code, 0) << streams << run.out;
    EXPECT_EQ(run.out, at("bar.xml") + "\n") << streams;
  }
  const Outcome run = run_command(fmt::format("{} convert {} --resample-steps 9 -o {} 2>&1 >&-", STBVH_AB,
                                              data("turning_bar.usda").string(), at("bar.xml")));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.out.find("stbvh-ab: Cannot write to standard output: Bad file descriptor."),
            std::string::npos)
      << run.out;
}

/// What a closed mesh encloses, above 0 where its faces are wound counterclockwise seen from outside.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto [a, b, c] = std::array{mesh.steps[0][mesh.indices[i]], mesh.steps[0][mesh.indices[i + 1]],
                                      mesh.steps[0][mesh.indices[i + 2]]};
    sum += double{a.x} * (double{b.y} * c.z - double{b.z} * c.y) +
           double{a.y} * (double{b.z} * c.x - double{b.x} * c.z) +
           double{a.z} * (double{b.x} * c.y - double{b.y} * c.x);
  }
  return sum / 6;
}

TEST_F(ShotsTest, FacesAreWoundCounterclockwise) {
  // Left-handed and mirrored: both or neither.
  EXPECT_GT(volume(*find_mesh(load(data("turning_bar.usda")), "/Axle/Bar")), 0);
  const Scene stones = load(data("nested_instances.usda"));
  EXPECT_GT(volume(*find_mesh(stones, "/Cart/Stones[0]/Cart/Stones/Kinds/Small")), 0);
  if (shared_shots().empty()) GTEST_SKIP() << "../shared is not there";
  EXPECT_GT(volume(load(shared_shots() / "rotatingCube.abc").meshes[0]), 0);  // Alembic winds clockwise
}

TEST_F(ShotsTest, UnitsAndUpAxisAreHonoured) {
  const Scene scene = load(data("turning_bar.usda"));
  const Mesh& plate = *find_mesh(scene, "/Axle/Plate");
  EXPECT_NEAR(plate.steps[0][0].y, 0.04, 1e-6);  // z = 10 - 6 centimeters
}

TEST_F(ShotsTest, InstancesAndLoopSurfaces) {
  const Scene scene = load(data("nested_instances.usda"));
  EXPECT_EQ(scene.meshes.size(), 4u);  // one of the three stones is invisible
  const Mesh* const large = find_mesh(scene, "/Cart/Stones[1]/Cart/Stones/Kinds/Large");
  ASSERT_NE(large, nullptr);
  EXPECT_EQ(large->triangle_count(), 4u * 64);
  EXPECT_EQ(large->faces.back(), 3u);
}

TEST_F(ShotsTest, AShutterIsAPartOfTheFile) {
  // Frames 1 to 3, of 24 a second.
  const Scene scene = load(data("velocities.usda"), {.shutter = {{1.0 / 24, 3.0 / 24}}});
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Splash", &Mesh::name), 2);
}

TEST_F(ShotsTest, AreReadWithinTheUsersOwnLimits) {
  const Outcome run = run_command(fmt::format("ulimit -t 600; {} convert {} -o {} 2>&1", STBVH_AB,
                                              data("velocities.usda").string(), at("out.xml")));
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_NE(run.out.find("--resample-steps"), std::string::npos) << run.out;  // it was read
}

TEST_F(ShotsTest, FramesAreTimeCodesOfAUsdFile) {
  const auto places = [this](const FilePart& part, const fs::path& file) {
    const Scene scene = load(file, {.shutter = part});
    std::vector<std::string> steps;
    for (const VertexBuffer& step : scene.meshes.at(0).steps)
      for (std::size_t vertex = 0; vertex < step.size(); ++vertex)
        steps.push_back(fmt::format("{} {} {}", step[vertex].x, step[vertex].y, step[vertex].z));
    return steps;
  };
  const fs::path bar = data("turning_bar.usda");  // 24 time codes a second
  EXPECT_EQ(places({1, 2, true}, bar), places({1.0 / 24, 2.0 / 24}, bar));
  EXPECT_EQ(places({1, 2, true, 12}, bar), places({2, 4, true}, bar));
  EXPECT_NE(places({1, 2, true}, bar), places({2, 4, true}, bar));
  if (shared_shots().empty()) GTEST_SKIP() << "../shared is not there";
  const fs::path cube = shared_shots() / "animatedCube.abc";
  EXPECT_EQ(places({3, 6, true, 12}, cube), places({0.25, 0.5}, cube));
  EXPECT_EQ(places({6, 12, true}, cube), places({0.25, 0.5}, cube));
}

TEST_F(ShotsTest, AFrameMayBeEmpty) {
  const fs::path file = write("blink.usda", R"(#usda 1.0
def Mesh "triangle" {
    token visibility.timeSamples = { 1: "inherited", 4: "invisible", 7: "inherited" }
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
})");
  EXPECT_EQ(load(file, {.shutter = FilePart{2, 3, true}}).meshes.size(), 1u);
  EXPECT_EQ(load(file, {.shutter = FilePart{5, 6, true}}).meshes.size(), 0u);
  EXPECT_THROW(load(file, {.shutter = FilePart{5.0 / 24, 6.0 / 24}}), SceneFileError);
}

/// Ours and those of others.
std::vector<std::string> all_files() {
  std::vector<std::string> files;
  for (const fs::path& file : files_in(fs::path(kSource) / "data")) files.push_back(file.string());
  if (const fs::path shots = shared_shots(); !shots.empty()) {
    for (const fs::path& file : files_in(shots)) files.push_back(file.string());
  }
  return files;
}

std::string all_files_listed() {
  return fmt::format("{}", fmt::join(all_files(), ","));
}

TEST_F(ShotsTest, OursAreRightOverAllOfThem) {
  const Outcome run =
      stbvh_ab("error --scenes " + all_files_listed() + " --structures stbvh,stbvh-direct --count 2000");
  EXPECT_EQ(run.exit_code, 0) << run.out;
}

TEST_F(ShotsTest, EveryStructureThatTakesTheirStepsIsCompared) {
  std::set<std::string> scenes;
  for (const char* const command : {"bench --repeats 1", "error"}) {
    const Outcome run =
        stbvh_ab(fmt::format("{} --scenes {} --structures all --rays uniform --count 100 --json {}", command,
                             all_files_listed(), at("records.json")));
    EXPECT_EQ(run.exit_code, 0) << run.out;
    EXPECT_NE(run.out.find("embree left out: Embree takes equidistant steps, 129 at most"),
              std::string::npos);
    std::map<std::string, std::set<std::string>> structures;  // of each scene
    const auto file = nlohmann::json::parse(read_file(at("records.json")));
    for (const auto& record : file.at("records")) {
      if (record.at("kind") == "speed" || record.at("kind") == "error")
        structures[record.at("scene")].insert(record.at("structure"));
    }
    EXPECT_EQ(structures.size(), all_files().size());
    for (const auto& [scene, names] : structures) {
      for (const std::string_view name : structure_names()) {
        EXPECT_TRUE(names.contains(std::string(name)) || !name.starts_with("stbvh")) << scene << ": " << name;
      }
    }
  }
}

TEST_F(ShotsTest, ResampledTheyAreEmbreesToo) {
  const Outcome run =
      stbvh_ab(fmt::format("error --scenes {} --structures embree,stbvh --rays uniform --count 500 "
                           "--resample-steps 129 --json {}",
                           all_files_listed(), at("records.json")));
  EXPECT_EQ(run.exit_code, 0) << run.out;
  const auto records = nlohmann::json::parse(read_file(at("records.json"))).at("records");
  EXPECT_EQ(records.size(), 2 * all_files().size());
}

TEST_F(ShotsTest, ACameraThatSomebodyMadeComesBeforeMayas) {
  const auto file = [this](const std::string& names) {
    std::string text = R"(#usda 1.0
def Mesh "Shown"
{
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
}
)";
    double x = 0;
    for (const char letter : names) {
      const std::string name = letter == 'f' ? "front" : letter == 'p' ? "persp" : "shotCam";
      text += fmt::format(
          "def Camera \"{}\"\n{{\n    double3 xformOp:translate = ({}, 0, 300)\n    uniform "
          "token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n",
          name, 100 * ++x);
    }
    return write("cameras.usda", text);
  };
  EXPECT_EQ(load(file("fps")).camera.position.x, 3);  // in meters
  EXPECT_EQ(load(file("fp")).camera.position.x, 2);
  EXPECT_EQ(load(file("f")).camera.position.x, 1);
  EXPECT_EQ(load(file("sf")).camera.position.x, 1);
  if (shared_shots().empty()) GTEST_SKIP() << "../shared is not there";
  EXPECT_LT(load(shared_shots() / "animatedCube.abc").camera.position.z, 5);  // not "front", at 100.1
}

}  // namespace
}  // namespace stbvh::harness
