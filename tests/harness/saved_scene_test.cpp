/// Scenes with their structure in a file.
#include "harness/scenes/saved/saved_scene.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "harness/structures/structure_under_test.h"
#include "plugin/files/output_file.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

void no_warning(const std::string& sentence) {
  ADD_FAILURE() << sentence;
}

Scene scene_with_everything() {
  Pcg32 random(3);
  Scene scene;
  scene.name = "everything";
  for (const std::size_t steps : {5u, 1u, 3u}) scene.meshes.push_back(wandering_triangles(50, steps, random));
  scene.meshes[0].name = "first";
  scene.meshes[0].material = {Material::Kind::kGlass, {0.1f, 0.2f, 0.3f}, 0.4f, 1.7f, {1, 2, 3}};
  scene.meshes[1].mask = 6;
  for (std::uint32_t t = 0; t < scene.meshes[1].triangle_count(); ++t) scene.meshes[1].faces.push_back(t / 2);
  scene.meshes[2].step_times = {0.0f, 0.1f, 1.0f};
  scene.camera = {{1, 2, 3}, {4, 5, 6}, {0, 0, 1}, 33};
  scene.camera_steps = {scene.camera, {{7, 8, 9}, {4, 5, 6}, {0, 1, 0}, 44}};
  scene.directional_lights = {{{1, 0, 0}, {2, 3, 4}, 5}};
  scene.point_lights = {{{1, 2, 3}, {4, 5, 6}, {1, 0, 0}, 20, 30}};
  scene.environment = Environment{{1, 2, 3}, 2, 1, {{4, 5, 6}, {7, 8, 9}}};
  scene.tolerance = 1e-6f;
  scene.max_bytes = 1'000'000;
  return scene;
}

TEST(SavedScene, IsWhatItWas) {
  const TemporaryFolder folder;
  const Scene scene = scene_with_everything();
  const auto structure = build_structure("stbvh-direct", scene, 1);
  const std::filesystem::path file = folder.path() / "scene.stbvh";
  write_file(file, to_saved_file(scene, *structure->tree()));
  const Scene again = load_saved(file, no_warning);
  ASSERT_EQ(again.meshes.size(), scene.meshes.size());
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    EXPECT_EQ(again.meshes[i].indices, scene.meshes[i].indices);
    EXPECT_EQ(again.meshes[i].faces, scene.meshes[i].faces);
    EXPECT_EQ(again.meshes[i].mask, scene.meshes[i].mask);
    EXPECT_EQ(again.meshes[i].step_times, scene.meshes[i].step_times);
    EXPECT_EQ(again.meshes[i].steps.size(), scene.meshes[i].steps.size());
    EXPECT_EQ(again.meshes[i].steps.back()[7].z, scene.meshes[i].steps.back()[7].z);
  }
  EXPECT_EQ(again.meshes[0].name, "first");
  EXPECT_EQ(again.meshes[0].material.kind, Material::Kind::kGlass);
  EXPECT_EQ(again.meshes[0].material.emission.z, 3);
  EXPECT_EQ(again.meshes[0].material.index_of_refraction, 1.7f);
  EXPECT_EQ(again.camera.vertical_fov_degrees, 33);
  ASSERT_EQ(again.camera_steps.size(), 2u);
  EXPECT_EQ(again.camera_steps[1].position.y, 8);
  ASSERT_EQ(again.directional_lights.size(), 1u);
  EXPECT_EQ(again.directional_lights[0].half_angle_degrees, 5);
  ASSERT_EQ(again.point_lights.size(), 1u);
  EXPECT_EQ(again.point_lights[0].outer_angle_degrees, 30);
  ASSERT_TRUE(again.environment);
  EXPECT_EQ(again.environment->width, 2u);
  EXPECT_EQ(again.environment->pixels[1].y, 8);
  EXPECT_EQ(again.tolerance, scene.tolerance);
  EXPECT_EQ(again.max_bytes, scene.max_bytes);
  // Its structure is that of the file, as long as its meshes are.
  const auto from_file = build_structure("stbvh-direct", again, 1);
  EXPECT_EQ(from_file->tree()->tree_hash(), structure->tree()->tree_hash());
  EXPECT_EQ(from_file->build_record().peak_bytes, from_file->build_record().structure_bytes);
  Scene changed = again;
  changed.meshes[0].steps[0][0].x += 0.5f;
  const auto built = build_structure("stbvh-direct", changed, 1);
  EXPECT_GT(built->build_record().peak_bytes, built->build_record().structure_bytes);
}

TEST(SavedScene, OfFilesThatAreNoneIsRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "scene.stbvh";
  const Scene scene = scene_with_everything();
  const auto structure = build_structure("stbvh-direct", scene, 1);
  const auto problem = [&](const std::string& bytes) {
    write_file(file, bytes);
    try {
      load_saved(file, no_warning);
    } catch (const SceneFileError& error) {
      return std::string(error.what()).substr(file.string().size() + 3);
    }
    return std::string();
  };
  const std::string good = to_saved_file(scene, *structure->tree());
  EXPECT_EQ(problem(good), "");
  EXPECT_EQ(problem(""), "is truncated.");
  EXPECT_EQ(problem(good.substr(0, good.size() / 2)), "is truncated.");
  EXPECT_EQ(problem(std::string(10000, 'x')), "is not a structure of STBVH.");
  std::string damaged = good;
  damaged[5000] = static_cast<char>(damaged[5000] + 1);
  EXPECT_EQ(problem(damaged), "is damaged.");
  EXPECT_EQ(problem(good + std::string(4096, 0)), "has another length than it says.");
  write_file(file, "");
  std::filesystem::resize_file(file, std::uintmax_t{100} << 30);  // more than can be mapped
  try {
    load_saved(file, no_warning);
    ADD_FAILURE();
  } catch (const SceneFileError& error) {
    EXPECT_NE(std::string(error.what()).find("is not a structure of STBVH"), std::string::npos)
        << error.what();
  }
  std::filesystem::remove(file);
  EXPECT_THROW(load_saved(file, no_warning), SceneFileError);
}

/// As expect_refusal(), after what the command has said until then.
void expect_late_refusal(const Outcome& run, const std::string& reason) {
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_NE(run.out.find("stbvh-ab: "), std::string::npos) << run.out;
  EXPECT_NE(run.out.find(reason), std::string::npos) << run.out;
}

TEST(SavedScene, IsBuiltByACommandAndTakenByOthers) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "wheels.stbvh").string();
  const Outcome built = stbvh_ab("build wheels --scale 0.01 -o " + file);
  EXPECT_EQ(built.exit_code, 0) << built.out;
  EXPECT_NE(built.out.find("there again in"), std::string::npos) << built.out;
  const Outcome asked = stbvh_ab("error --scenes " + file + " --structures stbvh-direct,stbvh --count 500");
  EXPECT_EQ(asked.exit_code, 0) << asked.out;
  expect_refusal(stbvh_ab("build wheels -o " + file + ".txt"), "build writes .stbvh files");
  const std::string pipe = (folder.path() / "pipe.stbvh").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  expect_refusal(stbvh_ab("build wheels -o " + pipe), "pipe.stbvh\" must be a file");
  expect_refusal(stbvh_ab("build all -o " + file), "one scene at a time");
  expect_refusal(stbvh_ab("error --scenes /no/such/file.stbvh"), "There is no file");
  write_file(file, "nothing");
  expect_late_refusal(stbvh_ab("convert " + file + " -o " + file + ".xml"), "is truncated");
}

TEST(EditsCommand, HoldsUpdatesAgainstBuilds) {
  const TemporaryFolder folder;
  const std::string json = (folder.path() / "edits.json").string();
  const Outcome run =
      stbvh_ab("edits --scenes crowd --scale 0.002 --edits 14 --count 300 --repeats 1 --json " + json);
  EXPECT_EQ(run.exit_code, 0) << run.out;
  for (const char* const word : {"embree", "stbvh", "moved", "masked", "0/300"})
    EXPECT_NE(run.out.find(word), std::string::npos) << run.out;
  EXPECT_TRUE(std::filesystem::exists(json));
  expect_refusal(stbvh_ab("edits --scenes crowd --scale 0.002 --structures lbvh"), "cannot be updated");
  expect_refusal(stbvh_ab("edits --kinds flown"), "flown");
}

TEST(FramesCommand, ComparesOneStructureWithManyOfThem) {
  const Outcome run =
      stbvh_ab("frames --scenes wheels --scale 0.01 --frames 3 --sampled 2 --count 300 --repeats 1");
  EXPECT_EQ(run.exit_code, 0) << run.out;
  for (const char* const word : {"embree", "lbvh", "stbvh", "crossover"})
    EXPECT_NE(run.out.find(word), std::string::npos) << run.out;
  expect_late_refusal(stbvh_ab("frames --scenes wheels --scale 0.01 --frames 2000"), "2000 frames");
}

}  // namespace
}  // namespace stbvh::harness
