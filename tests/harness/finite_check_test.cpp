/// Which triangles readers leave out because of where their vertices are.
#include "harness/scenes/finite_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace stbvh::harness {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A strip of `count` triangles over count + 2 vertices.
Mesh strip(const std::string& name, std::uint32_t count, std::size_t steps) {
  Mesh mesh;
  mesh.name = name;
  for (std::uint32_t i = 0; i < 3 * count; ++i) mesh.indices.push_back(i / 3 + i % 3);
  mesh.steps.assign(steps, VertexBuffer(count + 2));
  for (std::size_t s = 0; s < steps; ++s) {
    for (std::uint32_t v = 0; v < count + 2; ++v)
      mesh.steps[s][v] = {static_cast<float>(v), static_cast<float>(v % 2), static_cast<float>(s)};
  }
  return mesh;
}

std::vector<std::string> checked(Scene& scene) {
  std::vector<std::string> warnings;
  leave_out_invalid_triangles(scene, "a/file.xml",
                              [&](const std::string& sentence) { warnings.push_back(sentence); });
  return warnings;
}

TEST(FiniteCheck, LeavesWhatIsValidAlone) {
  Scene scene;
  scene.meshes = {strip("a", 3, 2), Mesh{}};
  scene.meshes[0].steps[1][4].x = std::nextafter(kMaxCoordinate, 0.0f);
  EXPECT_TRUE(checked(scene).empty());
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0].indices, strip("a", 3, 2).indices);
  EXPECT_EQ(scene.meshes[0].steps[1].size(), 5u);
}

TEST(FiniteCheck, TakesOutTrianglesAndVerticesAndNamesFileAndMesh) {
  for (const float bad : {kNan, kInfinity, -kInfinity, kMaxCoordinate, -kMaxCoordinate}) {
    Scene scene;
    scene.meshes = {strip("good", 2, 1), strip("bad", 4, 3)};
    scene.meshes[1].steps[1][1].y = bad;  // of the first two triangles, in one step only
    const std::vector<std::string> warnings = checked(scene);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0],
              "a/file.xml: 2 triangles are left out, with vertices that are not finite or too far away: "
              "2 of 4 in \"bad\"");
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.meshes[0].triangle_count(), 2u);
    const Mesh& mesh = scene.meshes[1];
    EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{1, 2, 3, 2, 3, 4}));
    ASSERT_EQ(mesh.steps.size(), 3u);
    for (const VertexBuffer& step : mesh.steps) {
      ASSERT_EQ(step.size(), 5u);
      for (std::size_t v = 0; v < 5; ++v) EXPECT_EQ(step[v].x, v == 0 ? 0.0f : static_cast<float>(v + 1));
    }
    EXPECT_EQ(scene.bounds().upper.x, 5);
  }
}

TEST(FiniteCheck, VerticesWithoutTrianglesGoWithoutAWord) {
  Scene scene;
  scene.meshes = {strip("a", 2, 1)};
  scene.meshes[0].indices.resize(3);
  scene.meshes[0].steps[0][3].x = kInfinity;
  EXPECT_TRUE(checked(scene).empty());
  EXPECT_EQ(scene.meshes[0].steps[0].size(), 3u);
  EXPECT_EQ(scene.bounds().upper.x, 2);
}

TEST(FiniteCheck, WholeMeshesGoAndManyAreCountedInOneLine) {
  Scene scene;
  for (int i = 0; i < 8; ++i) {
    scene.meshes.push_back(strip(std::string(1, static_cast<char>('a' + i)), 1, 2));
    if (i > 0) scene.meshes.back().steps[1][0].x = kNan;
  }
  const std::vector<std::string> warnings = checked(scene);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("7 triangles are left out"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("1 of 1 in \"f\", the rest in 2 more"), std::string::npos) << warnings[0];
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].name, "a");
}

}  // namespace
}  // namespace stbvh::harness
