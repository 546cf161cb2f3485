/// load_gltf() against positions that others computed, and what it makes of files that are right.
#include "harness/scenes/gltf/gltf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "harness/scenes/vec3.h"
#include "tests/harness/gltf_files.h"

namespace stbvh::harness {
namespace {

constexpr double kTolerance = 2e-6;  ///< of the diagonal

/// Compares all meshes, one behind the other, with [step][vertex][xyz] and triangles into that list.
void expect_matches(const Scene& scene, std::size_t steps, const std::vector<float>& positions,
                    const std::vector<std::uint32_t>& triangles, double diagonal) {
  const std::size_t vertices = positions.size() / 3 / steps;
  std::vector<std::uint32_t> indices;
  std::size_t first = 0;
  double worst = 0;
  for (const Mesh& mesh : scene.meshes) {
    for (const std::uint32_t index : mesh.indices)
      indices.push_back(static_cast<std::uint32_t>(first) + index);
    const std::size_t count = mesh.steps.front().size();
    ASSERT_LE(first + count, vertices);
    ASSERT_TRUE(mesh.steps.size() == 1 || mesh.steps.size() == steps);
    for (std::size_t s = 0; s < steps; ++s) {
      const VertexBuffer& step = mesh.steps[mesh.is_static() ? 0 : s];
      ASSERT_EQ(step.size(), count);
      for (std::size_t v = 0; v < count; ++v) {
        const float* p = &positions[3 * (s * vertices + first + v)];
        const auto difference = [](float a, float b) {
          return std::abs(static_cast<double>(a) - static_cast<double>(b));
        };
        const double far =
            std::hypot(difference(step[v].x, p[0]), difference(step[v].y, p[1]), difference(step[v].z, p[2]));
        ASSERT_FALSE(std::isnan(far));
        worst = std::max(worst, far);
      }
    }
    first += count;
  }
  EXPECT_EQ(first, vertices);
  EXPECT_EQ(indices, triangles);
  EXPECT_LE(worst, kTolerance * diagonal);
  testing::Test::RecordProperty("worst_share_of_diagonal", std::to_string(worst / diagonal));
  std::printf("  worst distance: %.2g of the diagonal\n", worst / diagonal);
}

class ReferenceTest : public testing::TestWithParam<const char*> {};

TEST_P(ReferenceTest, PositionsMatch) {
  const fs::path reference = kAssets / "reference" / GetParam();
  if (!fs::exists(reference.string() + ".json")) GTEST_SKIP() << "no reference in " << reference;
  const json info = json::parse(read_file(reference.string() + ".json"));
  GltfOptions options;
  options.clip = std::to_string(info["animationIndex"].get<int>());
  options.shutter = FilePart{info["t0"].get<double>(), info["t1"].get<double>()};
  options.steps = info["steps"].get<std::size_t>();
  const Scene scene = load_gltf(kAssets / info["file"].get<std::string>(), options);
  EXPECT_EQ(scene.triangle_count(), info["triangles"].get<std::size_t>());
  expect_matches(scene, options.steps, as_vector<float>(read_file(reference.string() + ".pos.bin")),
                 as_vector<std::uint32_t>(read_file(reference.string() + ".tri.bin")),
                 info["bboxDiagonal"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(Shared, ReferenceTest,
                         testing::Values("BoxAnimated", "CesiumMan", "CesiumMilkTruck", "Horse_Gallop",
                                         "InterpolationTest_CubicSplineRotation",
                                         "InterpolationTest_CubicSplineScale", "InterpolationTest_StepScale",
                                         "RobotExpressive_Dance"),
                         [](const auto& test) { return std::string(test.param); });

TEST(SharedAssets, AllLoad) {
  if (!fs::exists(kAssets)) GTEST_SKIP() << "no assets in " << kAssets;
  for (const fs::directory_entry& entry : fs::directory_iterator(kAssets)) {
    if (entry.path().extension() != ".glb") continue;
    const Scene scene = load_gltf(entry.path());
    EXPECT_GT(scene.triangle_count(), 0u) << entry.path();
    EXPECT_GT(scene.primitive_segment_count(), scene.triangle_count()) << entry.path() << " does not move";
  }
}

TEST(SharedAssets, NanWeightsFollowTheFirstJoint) {
  if (!fs::exists(kAssets / "malformed/Wasp.glb")) GTEST_SKIP() << "no malformed assets in " << kAssets;
  const Scene malformed = load_gltf(kAssets / "malformed/Wasp.glb"),
              repaired = load_gltf(kAssets / "Wasp.glb");
  ASSERT_EQ(malformed.meshes.size(), repaired.meshes.size());
  for (std::size_t m = 0; m < malformed.meshes.size(); ++m) {
    ASSERT_EQ(malformed.meshes[m].steps.size(), repaired.meshes[m].steps.size());
    for (std::size_t s = 0; s < malformed.meshes[m].steps.size(); ++s) {
      const VertexBuffer &a = malformed.meshes[m].steps[s], &b = repaired.meshes[m].steps[s];
      ASSERT_EQ(a.size(), b.size());
      EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3f)), 0);
    }
  }
}

class OwnFileTest : public testing::TestWithParam<const char*> {};

TEST_P(OwnFileTest, PositionsMatchTheGenerators) {
  const std::string expected = read_file(kData / "expected" / (std::string(GetParam()) + ".bin"));
  ASSERT_GE(expected.size(), 12u);
  const auto counts = as_vector<std::uint32_t>(expected.substr(0, 12));
  const std::size_t index_bytes = std::size_t{12} * counts[2];
  ASSERT_EQ(expected.size(), 12 + index_bytes + std::size_t{12} * counts[0] * counts[1]);
  GltfOptions options;
  options.steps = counts[0];
  const Scene scene = load_gltf(kData / (std::string(GetParam()) + ".glb"), options);
  const Box3f box = scene.bounds();
  const double diagonal =
      std::hypot(box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z);
  expect_matches(scene, counts[0], as_vector<float>(expected.substr(12 + index_bytes)),
                 as_vector<std::uint32_t>(expected.substr(12, index_bytes)), diagonal);
}

INSTANTIATE_TEST_SUITE_P(Data, OwnFileTest, kOwnFiles,
                         [](const auto& test) { return std::string(test.param); });

TEST(Gltf, WhatStandsStillHasOneStep) {
  const Scene scene = load_gltf(kData / "propeller.glb");
  ASSERT_EQ(scene.meshes.size(), 5u);
  EXPECT_EQ(scene.name, "propeller");
  EXPECT_EQ(scene.meshes[0].name, "mast");
  EXPECT_EQ(scene.meshes[0].steps.size(), 1u);
  for (std::size_t i = 1; i < 5; ++i) EXPECT_EQ(scene.meshes[i].steps.size(), 9u);
  EXPECT_FLOAT_EQ(scene.meshes[1].material.color.y, 0.7f);
  const GltfOptions at_begin{"spin", FilePart{0.5, 0.5}, 1};
  for (const Mesh& mesh : load_gltf(kData / "propeller.glb", at_begin).meshes)
    EXPECT_EQ(mesh.steps.size(), 1u);
}

/// Largest share of the picture's half width or height at which a vertex of any step stands.
double picture_reach(const Scene& scene) {
  const Vec3 position = to_double(scene.camera.position);
  const Vec3 forward = normalize(to_double(scene.camera.target) - position);
  const Vec3 right = normalize(cross(forward, to_double(scene.camera.up)));
  const double half_height = std::tan(scene.camera.vertical_fov_degrees * kPi / 360);
  double reach = 0;
  for (const Mesh& mesh : scene.meshes) {
    for (const VertexBuffer& step : mesh.steps) {
      for (const Vec3f& p : step.span()) {
        const Vec3 to = to_double(p) - position;
        EXPECT_GT(dot(to, forward), 0);
        const double x = dot(to, right) / dot(to, forward) / (kPictureAspect * half_height);
        const double y = dot(to, cross(right, forward)) / dot(to, forward) / half_height;
        reach = std::max({reach, std::abs(x), std::abs(y)});
      }
    }
  }
  return reach;
}

TEST(Gltf, CameraSeesTheWholeAnimationFromNearby) {
  for (const char* name : {"bending_tube", "morphing_sphere", "propeller", "quantised_flag"}) {
    const double reach = picture_reach(load_gltf(kData / (std::string(name) + ".glb")));
    EXPECT_LE(reach, 1.0) << name;
    EXPECT_GE(reach, 0.95) << name;
  }
}

TEST(Gltf, ClipsAndShutters) {
  const fs::path file = kData / "propeller.glb";
  EXPECT_EQ(refusal(file, {"spin", {}, 9}), "");
  EXPECT_EQ(refusal(file, {"0", {}, 9}), "");
  EXPECT_EQ(refusal(file, {"nod", {}, 9}), "it has no clip 'nod'; its clips are 0 'spin'");
  expect_refused(file, "its clips are", {"1", {}, 9});
  expect_refused(file, "the shutter must open before it closes", {"", FilePart{0.5, 0.5}, 2});
  expect_refused(file, "the shutter must open before it closes", {"", FilePart{1, 0}, 2});
  expect_refused(file, "the shutter", {"", FilePart{0, std::numeric_limits<double>::quiet_NaN()}, 2});
  expect_refused(file, "1 to 129 are possible", {"", {}, 0});
  expect_refused(file, "1 to 129 are possible", {"", {}, kMaxSceneSteps + 1});
  EXPECT_EQ(load_gltf(file, {"", {}, kMaxSceneSteps}).meshes[1].steps.size(), kMaxSceneSteps);
}

TEST_F(GltfTest, IndexTypesAndTopologies) {
  using Indices = std::vector<std::uint32_t>;
  const auto indices_of = [&](const std::function<void(Document&)>& change) {
    Document document;
    change(document);
    const fs::path file = write("mesh.glb", document.bytes());
    return load_gltf(file).meshes.at(0).indices;
  };
  const Indices square{0, 1, 2, 0, 2, 3};
  EXPECT_EQ(indices_of([](Document&) {}), square);
  EXPECT_EQ(indices_of([](Document& d) {
              d.primitive()["indices"] = d.add<std::uint8_t>("SCALAR", 5121, {0, 1, 2, 0, 2, 3});
            }),
            square);
  EXPECT_EQ(indices_of([](Document& d) {
              d.primitive()["indices"] = d.add<std::uint32_t>("SCALAR", 5125, {0, 1, 2, 0, 2, 3, 1});
            }),
            square);
  EXPECT_EQ(indices_of([](Document& d) { d.primitive().erase("indices"); }), (Indices{0, 1, 2}));
  EXPECT_EQ(indices_of([](Document& d) {
              d.primitive().erase("indices");
              d.primitive()["mode"] = 5;
            }),
            (Indices{0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(indices_of([](Document& d) {
              d.primitive().erase("indices");
              d.primitive()["mode"] = 6;
            }),
            (Indices{1, 2, 0, 2, 3, 0}));
  EXPECT_EQ(indices_of([](Document& d) {  // points in front
              json points = d.primitive();
              points["mode"] = 0;
              d.root["meshes"][0]["primitives"] = {points, d.primitive()};
            }),
            square);
  Document lines;
  lines.primitive()["mode"] = 1;
  expect_refused(write("lines.glb", lines.bytes()), "has no triangles");
}

TEST_F(GltfTest, SkinWeights) {
  // Joint k moves by k + 1 along x; vertices: NaN beside 8-bit-like halves, all zero, a second set, quarters.
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Document d;
  json& attributes = d.primitive()["attributes"];
  attributes["JOINTS_0"] =
      d.add<std::uint16_t>("VEC4", 5123, {0, 1, 2, 0, 2, 1, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3});
  attributes["WEIGHTS_0"] =
      d.add<float>("VEC4", 5126, {kNan, 3, 1, 0, 0, 0, 0, kNan, 1, 0, 0, 0, 1, 1, 1, 1});
  attributes["JOINTS_1"] =
      d.add<std::uint8_t>("VEC4", 5121, {0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 9, 0, 0, 0, 0});
  attributes["WEIGHTS_1"] =
      d.add<std::uint8_t>("VEC4", 5121, {0, 0, 0, 0, 0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0}, true);
  d.root["skins"] = {{{"joints", {1, 2, 3, 4}}}};
  d.root["nodes"][0].update({{"skin", 0}, {"translation", {100, 0, 0}}});
  for (int k = 0; k < 4; ++k) d.root["nodes"].push_back({{"translation", {k + 1, 0, 0}}});
  d.root["scenes"][0]["nodes"] = {0, 1, 2, 3, 4};
  const Scene scene = load_gltf(write("skin.glb", d.bytes()));
  const VertexBuffer& p = scene.meshes.at(0).steps.at(0);
  EXPECT_FLOAT_EQ(p[0].x, 0 + 0.75f * 2 + 0.25f * 3);
  EXPECT_FLOAT_EQ(p[1].x, 1 + 3);
  EXPECT_FLOAT_EQ(p[2].x, 1 + 0.5f * 1 + 0.5f * 4);
  EXPECT_FLOAT_EQ(p[3].x, 0 + 2.5f);
  d.root["skins"][0]["joints"] = {1, 2, 3};
  expect_refused(write("joint.glb", d.bytes()), "follows joint 3 of a skin with 3 joints");
}

TEST_F(GltfTest, KeysHoldBeforeBehindAndAtTheirTimes) {
  Document d;
  const int times = d.add<float>("SCALAR", 5126, {1, 2, 3});
  const int places = d.add<float>("VEC3", 5126, {0, 0, 0, 10, 0, 0, 20, 0, 0});
  d.root["animations"] =
      json::parse(R"([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
      "samplers": [{"interpolation": "STEP"}]}])");
  d.root["animations"][0]["samplers"][0].update({{"input", times}, {"output", places}});
  const auto first_vertex_at = [&](std::optional<FilePart> shutter, std::size_t steps) {
    const Scene scene = load_gltf(write("keys.glb", d.bytes()), {"", shutter, steps});
    std::vector<float> x;
    for (const VertexBuffer& step : scene.meshes.at(0).steps) x.push_back(step[0].x);
    return x;
  };
  using Floats = std::vector<float>;
  EXPECT_EQ(first_vertex_at({}, 3), (Floats{0, 10, 20}));
  EXPECT_EQ(first_vertex_at(FilePart{0, 4}, 5), (Floats{0, 0, 10, 20, 20}));
  EXPECT_EQ(first_vertex_at(FilePart{2, 2}, 1), (Floats{10}));
  d.root["animations"][0]["samplers"][0]["interpolation"] = "LINEAR";
  EXPECT_EQ(first_vertex_at(FilePart{0, 4}, 9), (Floats{0, 0, 0, 5, 10, 15, 20, 20, 20}));
  d.root["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1};
  expect_refused(write("matrix.glb", d.bytes()), "is animated, but has a matrix");
  d.root.erase("animations");
  EXPECT_EQ(first_vertex_at({}, 9), (Floats{7}));
  expect_refused(write("still.glb", d.bytes()), "it has no clip 'walk', for it has none at all",
                 {"walk", {}, 9});
}

TEST_F(GltfTest, SeparateBuffers) {
  Document d;
  write("a b.bin", d.binary + "more than byteLength");
  d.root["buffers"][0]["uri"] = "a%20b.bin";
  d.root["images"] = {{{"uri", "missing.png"}}};  // images are never opened
  EXPECT_EQ(load_gltf(write("file.gltf", d.root.dump(1))).triangle_count(), 2u);
  d.root["buffers"][0]["uri"] = "c.bin";
  expect_refused(write("missing.gltf", d.root.dump()), "'c.bin', to which buffer 0 refers, does not exist");
  d.root["buffers"][0]["uri"] = ".";
  expect_refused(write("folder.gltf", d.root.dump()), "is not a regular file");
  d.root["buffers"][0].erase("uri");
  expect_refused(write("none.gltf", d.root.dump()), "buffer 0 has no data");
  d.root["buffers"] = {
      {{"uri", "data:application/octet-stream;base64,AAAAAAAAAAAAAAAA"}, {"byteLength", 12}}};
  d.root["bufferViews"] = {{{"buffer", 0}, {"byteLength", 12}}};
  d.root["accessors"] = {{{"bufferView", 0}, {"componentType", 5121}, {"count", 3}, {"type", "VEC3"}}};
  d.primitive().erase("indices");
  EXPECT_EQ(load_gltf(write("data.gltf", d.root.dump())).triangle_count(), 1u);
  d.root["buffers"][0]["byteLength"] = 13;
  expect_refused(write("short.gltf", d.root.dump()), "buffer 0 should have 13 bytes, but only 12 are there");
}

}  // namespace
}  // namespace stbvh::harness
