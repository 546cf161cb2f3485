/// What load_gltf() reads besides meshes that move: instances, visibility, pointers, cameras, lights, scenes;
/// and what it says of the rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "harness/scenes/vec3.h"
#include "tests/harness/gltf_files.h"

namespace stbvh::harness {
namespace {

using Floats = std::vector<float>;
using Strings = std::vector<std::string>;

const fs::path kCases = fs::path(STBVH_SOURCE_DIR) / "../shared/cases";

class GltfSceneTest : public GltfTest {
 protected:
  Scene load_file(const fs::path& file, const GltfOptions& options = {}) {
    warnings.clear();
    return load_gltf(file, options, [&](const std::string& sentence) {
      EXPECT_TRUE(sentence.starts_with(file.string() + ": ")) << sentence;
      EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
      warnings.push_back(sentence.substr(std::min(sentence.size(), file.string().size() + 2)));
    });
  }

  Scene load(const Document& d, const GltfOptions& options = {}) {
    return load_file(write("file.glb", d.bytes()), options);
  }

  std::string expect_one_warning() const {
    EXPECT_EQ(warnings.size(), 1u) << testing::PrintToString(warnings);
    return warnings.empty() ? std::string() : warnings[0];
  }

  Strings warnings;
};

/// Keys of the animation pointer's target, or of a node where `target` is an object.
void animate(Document& d, const json& target, const Floats& times, int output,
             const std::string& interpolation = "LINEAR") {
  json& animation = d.root["animations"][0];
  const int input = d.add<float>("SCALAR", 5126, times);
  const json whole =
      target.is_string()
          ? json{{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", target}}}}}}
          : target;
  animation["channels"].push_back({{"sampler", animation["channels"].size()}, {"target", whole}});
  animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
}

int places(Document& d, const Floats& values) {
  return d.add<float>("VEC3", 5126, values);
}

Floats first_x(const Mesh& mesh) {
  Floats x;
  for (const VertexBuffer& step : mesh.steps) x.push_back(step[0].x);
  return x;
}

void expect_near(Vec3f a, Vec3 b, double tolerance = 1e-6) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST_F(GltfSceneTest, InstancesMoveWithTheirNode) {
  Document d;
  json& attributes = d.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["TRANSLATION"] = places(d, {0, 0, 0, 10, 0, 0, 20, 0, 5});
  // The last turns by 90 degrees about z, in normalised shorts.
  attributes["ROTATION"] =
      d.add<std::int16_t>("VEC4", 5122, {0, 0, 0, 32767, 0, 0, 0, 32767, 0, 0, 23170, 23170}, true);
  attributes["SCALE"] = places(d, {1, 1, 1, 2, 2, 2, 3, 3, 3});
  attributes["_ID"] = d.add<float>("SCALAR", 5126, {7, 8, 9});
  d.root["nodes"][0]["name"] = "tree";
  animate(d, {{"node", 0}, {"path", "translation"}}, {0, 1}, places(d, {0, 0, 0, 1, 0, 0}));
  const Scene scene = load(d, {"", {}, 2});
  EXPECT_TRUE(warnings.empty()) << warnings[0];
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.meshes[1].name, "tree [1]");
  for (const Mesh& mesh : scene.meshes) EXPECT_EQ(mesh.triangle_count(), 2u);
  EXPECT_EQ(first_x(scene.meshes[0]), (Floats{0, 1}));
  EXPECT_EQ(first_x(scene.meshes[1]), (Floats{10, 11}));
  expect_near(scene.meshes[1].steps[0][2], {12, 2, 0});
  expect_near(scene.meshes[2].steps[0][1], {20, 3, 5}, 1e-4);
  expect_near(scene.meshes[2].steps[1][1], {21, 3, 5}, 1e-4);

  attributes["SCALE"] = places(d, {1, 1, 1});
  expect_refused(write("counts.glb", d.bytes()), "of the instances of node 0 have different counts");
  attributes = json::object();
  expect_refused(write("none.glb", d.bytes()), "the instances of node 0 have no attributes");
}

/// Nodes 0 and 1 with a mesh each, 1 below 2; node 2 is a root too.
Document two_nodes() {
  Document d;
  d.root["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {0, 5, 0}}}, {{"children", {1}}}};
  d.root["scenes"][0]["nodes"] = {0, 2};
  return d;
}

TEST_F(GltfSceneTest, WhatIsHiddenHidesWhatIsBelow) {
  Document d = two_nodes();
  d.root["nodes"][2]["extensions"]["KHR_node_visibility"]["visible"] = false;
  d.root["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = true;
  const Scene scene = load(d);
  EXPECT_TRUE(warnings.empty());
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].name, "node 0");
  d.root["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = false;
  expect_refused(write("hidden.glb", d.bytes()), "all meshes of its scene are hidden");
  d.root["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = 0;
  expect_refused(write("number.glb", d.bytes()), "visible is 0, which is neither true nor false");
}

TEST_F(GltfSceneTest, PointersMoveNodes) {
  Document d = two_nodes();
  animate(d, "/nodes/2/translation", {0, 2}, places(d, {0, 0, 0, 8, 0, 0}));
  animate(d, "/nodes/1/scale", {0, 2}, places(d, {1, 1, 1, 3, 3, 3}));
  const Scene scene = load(d, {"", {}, 3});
  EXPECT_TRUE(warnings.empty());
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_TRUE(scene.meshes[0].is_static());
  EXPECT_EQ(first_x(scene.meshes[1]), (Floats{0, 4, 8}));
  EXPECT_EQ(scene.meshes[1].steps[2][1].x, 11);
}

TEST_F(GltfSceneTest, PointersMoveWeights) {
  Document d;
  const int offset = places(d, {4, 0, 0, 4, 0, 0, 4, 0, 0, 4, 0, 0});
  d.primitive()["targets"] = {{{"POSITION", offset}}, {{"POSITION", offset}}};
  d.root["meshes"][0]["weights"] = {0.25, 0};
  animate(d, "/nodes/0/weights/1", {0, 1}, d.add<float>("SCALAR", 5126, {0, 1}));
  EXPECT_EQ(first_x(load(d, {"", {}, 3}).meshes.at(0)), (Floats{1, 3, 5}));
  d.root.erase("animations");
  animate(d, "/nodes/0/weights", {0, 1}, d.add<float>("SCALAR", 5126, {0, 0, 1, 0.5f}));
  EXPECT_EQ(first_x(load(d, {"", {}, 3}).meshes.at(0)), (Floats{0, 3, 6}));
}

TEST_F(GltfSceneTest, WhatIsShownAndHiddenHasTimeRanges) {
  Document d = two_nodes();
  animate(d, "/nodes/2/extensions/KHR_node_visibility/visible", {0, 1, 2, 3},
          d.add<std::uint8_t>("SCALAR", 5121, {0, 1, 1, 0}), "STEP");
  animate(d, {{"node", 0}, {"path", "translation"}}, {0, 4}, places(d, {0, 0, 0, 8, 0, 0}));
  Scene scene = load(d, {"", {}, 3});
  EXPECT_TRUE(warnings.empty());
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0].time_range.end, 1);
  EXPECT_EQ(scene.meshes[1].time_range.begin, 0.25f);
  EXPECT_EQ(scene.meshes[1].time_range.end, 0.75f);
  EXPECT_EQ(first_x(scene.meshes[1]), (Floats{0, 0}));  // one step alone would always be visible

  // What moves meanwhile has its steps where it is to be seen.
  animate(d, {{"node", 1}, {"path", "translation"}}, {0, 4}, places(d, {0, 0, 0, 8, 0, 0}));
  scene = load(d, {"", {}, 3});
  EXPECT_EQ(first_x(scene.meshes.at(1)), (Floats{2, 4, 6}));
  GltfOptions adaptive;
  adaptive.largest_deviation = 1e-3;
  scene = load(d, adaptive);
  EXPECT_EQ(first_x(scene.meshes.at(1)), (Floats{2, 6}));
  EXPECT_EQ(scene.meshes.at(1).time_range.begin, 0.25f);
  // At one moment it is there or not.
  EXPECT_EQ(load(d, {"", FilePart{0.5, 0.5}, 1}).meshes.size(), 1u);
  EXPECT_EQ(load(d, {"", FilePart{1.5, 1.5}, 1}).meshes.size(), 2u);

  d.root["animations"][0]["samplers"][0]["interpolation"] = "LINEAR";
  expect_refused(write("linear.glb", d.bytes()), "the visibility of node 2 is animated, but not in steps");
}

TEST_F(GltfSceneTest, AnimationsBesidesTheFirstAreCounted) {
  Document d;
  animate(d, {{"node", 0}, {"path", "translation"}}, {0, 1}, places(d, {0, 0, 0, 1, 0, 0}));
  load(d);
  EXPECT_TRUE(warnings.empty());
  d.root["animations"].push_back(d.root["animations"][0]);
  load(d);
  EXPECT_EQ(expect_one_warning(), "left out, as the first is taken: 1 more animation (--clip)");
  GltfOptions options;
  options.clip = "0";
  load(d, options);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(GltfSceneTest, WhatIsSkinnedIsShownOnce) {
  Document d;
  d.primitive()["attributes"]["JOINTS_0"] =
      d.add<std::uint8_t>("VEC4", 5121, std::vector<std::uint8_t>(16, 0));
  d.primitive()["attributes"]["WEIGHTS_0"] =
      d.add<float>("VEC4", 5126, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  d.root["nodes"].push_back({{"translation", {0, 0, 7}}});
  d.root["scenes"][0]["nodes"] = {0, 1};
  d.root["skins"] = {{{"joints", {1}}}};
  json& node = d.root["nodes"][0];
  node["skin"] = 0;
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      places(d, {1, 0, 0, 2, 0, 0, 3, 0, 0});
  const Scene scene = load(d);
  EXPECT_EQ(expect_one_warning(), "left out, as what is skinned is shown once: the instances of 1 node");
  ASSERT_EQ(scene.meshes.size(), 1u);
  expect_near(scene.meshes[0].steps[0][0], {0, 0, 7});
  d.primitive()["attributes"].erase("WEIGHTS_0");
  EXPECT_EQ(load(d).meshes.size(), 3u);
  EXPECT_EQ(expect_one_warning(),
            "left out: joints without weights, or weights without joints, of 1 primitive");
  d.primitive()["attributes"].erase("JOINTS_0");
  EXPECT_EQ(load(d).meshes.size(), 3u);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(GltfSceneTest, VerticesThatMakeNoTriangleAreTold) {
  Document d;
  d.primitive()["indices"] = d.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2});
  EXPECT_EQ(load(d).triangle_count(), 1u);
  EXPECT_EQ(expect_one_warning(),
            "left out: the last vertices, which make no whole triangle, of 1 primitive");
  d.primitive()["mode"] = 5;
  EXPECT_GE(load(d).triangle_count(), 1u);
  EXPECT_TRUE(warnings.empty());
  d.primitive()["mode"] = 4;
  d.primitive().erase("indices");
  EXPECT_EQ(load(d).triangle_count(), 1u);
  expect_one_warning();
}

TEST_F(GltfSceneTest, MetalIsTheDefault) {
  Document d;
  d.primitive()["material"] = 0;
  for (const char* material :
       {R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}})", R"({"name": "steel"})",
        R"({"pbrMetallicRoughness": {"metallicFactor": 1}})",
        R"({"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.5}})"}) {
    d.root["materials"] = {json::parse(material)};
    load(d);
    EXPECT_EQ(expect_one_warning(), "left out: metal and roughness of 1 material") << material;
  }
  d.root["materials"] = {{{"pbrMetallicRoughness", {{"metallicFactor", 0}}}}};
  load(d);
  EXPECT_TRUE(warnings.empty());
}

/// With data of their own they are read; otherwise they would be at zero.
TEST_F(GltfSceneTest, WhatIsThereOnlyCompressedIsLeftOut) {
  Document d;
  json draco = d.primitive();
  draco["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  d.root["meshes"][0]["primitives"].push_back(draco);
  EXPECT_EQ(load(d).meshes.size(), 2u);
  d.root["accessors"].push_back({{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  d.root["meshes"][0]["primitives"][1]["attributes"]["POSITION"] = d.root["accessors"].size() - 1;
  EXPECT_EQ(load(d).meshes.size(), 1u);
  EXPECT_EQ(expect_one_warning(),
            "left out: 1 primitive with Draco mesh compression (KHR_draco_mesh_compression) alone");
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    Document meshopt;
    meshopt.root["buffers"][0]["extensions"][name]["fallback"] = true;
    expect_refused(write("meshopt.glb", meshopt.bytes()), "buffer 0 is there only with meshopt compression");
    meshopt.root["buffers"][0]["extensions"][name]["fallback"] = false;
    EXPECT_EQ(load(meshopt).triangle_count(), 2u);
  }
}

TEST_F(GltfSceneTest, WhatNothingUsesMayBeWrong) {
  Document d;
  d.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 3.2}}}}};
  d.root["materials"] = {{{"emissiveFactor", {0, -1, 0}}}};
  d.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "area"}}};
  EXPECT_EQ(load(d).triangle_count(), 2u);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(GltfSceneTest, ExtrasMayHoldAnything) {
  const auto with = [](const std::string& name, const std::string& value) {
    Document d;
    d.root["nodes"][0]["extras"] = "VALUE";
    d.root["extensions"]["EXT_other"] = "VALUE";
    d.root["buffers"][0]["uri"] = "square.bin";
    std::string text = d.root.dump();
    const std::string mark = "\"" + name + "\":\"VALUE\"";
    return text.replace(text.find(mark), mark.size(), "\"" + name + "\" : " + value);
  };
  write("square.bin", Document().binary);
  const std::string deep = std::string(150'000, '[') + std::string(150'000, ']');
  std::string objects = "0";
  for (int i = 0; i < 150; ++i) objects = "{\"a\": [" + objects + ", \"]}\\\"\"]}";
  for (const std::string& value : {deep, objects, std::string("1e400"), std::string(400, '9'),
                                   std::string("{}"), std::string("[-1e999, {\"extras\": 1e999}]"),
                                   std::string("\"[\""), std::string("null"), std::string("true")}) {
    for (const char* name : {"extras", "EXT_other"}) {
      const Scene scene = load_file(write("extras.gltf", with(name, value)));
      EXPECT_EQ(scene.triangle_count(), 2u);
      EXPECT_TRUE(warnings.empty());
    }
  }
  // What is read keeps its rules, and what is broken is refused.
  expect_refused(write("broken.gltf", with("extras", "[}")), "its JSON is broken at byte");
  expect_refused(write("broken.gltf", with("extras", "[[")), "its JSON is broken at byte");
  expect_refused(write("broken.gltf", with("extras", "")), "its JSON is broken at byte");
  std::string large = Document().root.dump();
  large.replace(large.find("\"mesh\":0"), 8, "\"mesh\":1e400");
  expect_refused(write("large.gltf", large), "a number out of range");
}

TEST_F(GltfSceneTest, ChannelsThatAreNotReadAreCounted) {
  Document d;
  d.root["materials"] = {json::object(), json::object()};
  for (int material = 0; material < 2; ++material) {
    animate(d, "/materials/" + std::to_string(material) + "/pbrMetallicRoughness/baseColorFactor", {0, 1},
            d.add<float>("VEC4", 5126, {0, 0, 0, 1, 1, 1, 1, 1}));
  }
  animate(d, "/nodes/0/extensions/KHR_lights_punctual/light", {0, 1}, places(d, {0, 0, 0, 1, 0, 0}));
  load(d);
  EXPECT_EQ(expect_one_warning(),
            "left out: channels of the animation that move what is not read: 2 of "
            "/materials/*/pbrMetallicRoughness/baseColorFactor, 1 of "
            "/nodes/*/extensions/KHR_lights_punctual/light");
}

TEST_F(GltfSceneTest, TheFirstPerspectiveCameraLooksAlongMinusZ) {
  Document d = two_nodes();
  d.root["cameras"] = {{{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}}}},
                       {{"type", "perspective"}, {"perspective", {{"yfov", kPi / 3}, {"znear", 0.1}}}}};
  const double half = std::sqrt(0.5);
  d.root["nodes"].push_back({{"camera", 0}});
  d.root["nodes"].push_back({{"camera", 1}, {"rotation", {0, half, 0, half}}, {"translation", {9, 1, 2}}});
  d.root["nodes"].push_back({{"camera", 1}});
  d.root["scenes"][0]["nodes"] = {0, 2, 3, 4, 5};
  const Camera camera = load(d).camera;
  EXPECT_EQ(warnings.size(), 2u);
  expect_near(camera.position, {9, 1, 2});
  // Turned by 90 degrees about y, -z is -x; the middle of the scene is at x = 0.5.
  expect_near(camera.target, {0.5, 1, 2}, 1e-5);
  expect_near(camera.up, {0, 1, 0});
  EXPECT_NEAR(camera.vertical_fov_degrees, 60, 1e-4);
}

TEST_F(GltfSceneTest, CamerasMoveWithTheirNodes) {
  Document d = two_nodes();
  d.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  d.root["nodes"].push_back({{"camera", 0}});
  d.root["nodes"].push_back({{"children", {3}}, {"translation", {0, 0, 5}}});
  d.root["scenes"][0]["nodes"] = {0, 2, 4};
  Scene scene = load(d);
  EXPECT_TRUE(scene.camera_steps.empty());
  expect_near(scene.camera.position, {0, 0, 5});
  animate(d, {{"node", 4}, {"path", "translation"}}, {0, 1}, places(d, {0, 0, 5, 4, 0, 5}));
  scene = load(d, {"", {}, 3});
  EXPECT_TRUE(warnings.empty());
  ASSERT_EQ(scene.camera_steps.size(), 3u);
  expect_near(scene.camera.position, {0, 0, 5});
  expect_near(scene.camera_at(0.25).position, {1, 0, 5});
  expect_near(scene.camera_at(0.25).target, {1, 0, scene.camera.target.z});
  expect_near(scene.camera_at(1).position, {4, 0, 5});
  animate(d, {{"node", 4}, {"path", "translation"}}, {0, 1}, places(d, {0, 0, 5, 1e30f, 0, 5}));
  EXPECT_TRUE(load(d).camera_steps.empty());
  EXPECT_EQ(expect_one_warning(), "left out: a camera that is too far away");
}

/// A node above that is turned and scaled; what it carries follows only its turn.
TEST_F(GltfSceneTest, CamerasAndLightsAreTurnedWhateverScalesThem) {
  Document d;
  d.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  d.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}}, {{"type", "spot"}}};
  const double half = std::sqrt(0.5);
  d.root["nodes"].push_back({{"children", {2, 3}}, {"rotation", {0, half, 0, half}}});  // -z becomes -x
  d.root["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
  d.root["nodes"].push_back({{"children", {4}}});
  d.root["nodes"].push_back({{"rotation", {0, 0, 1, 0}}});
  for (std::size_t i = 0; i < 2; ++i)
    d.root["nodes"][3 + i]["extensions"]["KHR_lights_punctual"]["light"] = i;
  d.root["scenes"][0]["nodes"] = {0, 1};
  for (const json& scale :
       {json{1, 1, 0}, json{0, 0, 0}, json{-1, 1, 0}, json{1, 0, 1}, json{1e-200, 1e-200, 1e-200},
        json{1e-320, 1e-320, 1e-320}, json{1e200, 1e200, 1e200}, json{1, 1, 1e-30}}) {
    SCOPED_TRACE(scale.dump());
    for (const std::size_t node : {1u, 2u, 3u}) {
      d.root["nodes"][1].erase("scale");
      d.root["nodes"][2].erase("scale");
      d.root["nodes"][3].erase("scale");
      d.root["nodes"][node]["scale"] = scale;
      if (node == 1 && scale[2].get<double>() > 1) continue;  // far away then
      const Scene scene = load(d);
      EXPECT_TRUE(warnings.empty()) << warnings[0];
      const Vec3 axis = to_double(scene.camera.target) - to_double(scene.camera.position);
      expect_near(to_float(normalize(axis)), {-1, 0, 0});
      expect_near(scene.camera.up, {0, 1, 0});
      expect_near(scene.directional_lights.at(0).direction, {-1, 0, 0});
      expect_near(scene.point_lights.at(0).axis, {-1, 0, 0});
    }
  }
  for (const std::size_t node : {2u, 3u})
    d.root["nodes"][node] = {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}}};
  d.root["nodes"][2]["camera"] = 0;
  d.root["nodes"][3]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  EXPECT_TRUE(load(d).directional_lights.empty());
  EXPECT_EQ(warnings, (Strings{"left out: a camera that does not look anywhere",
                               "left out, as their nodes give them no direction: 1 light"}));
  for (const std::size_t node : {2u, 3u})
    d.root["nodes"][node]["matrix"] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  expect_near(load(d).directional_lights.at(0).direction, {-1, 0, 0});
  EXPECT_EQ(expect_one_warning(), "left out: a camera that has no up, or one along its view");
}

TEST_F(GltfSceneTest, CamerasAndLightsThatAreFarAway) {
  Document d;
  d.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  d.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}}, {{"type", "point"}}};
  for (int i = 0; i < 2; ++i)
    d.root["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  d.root["nodes"].push_back({{"camera", 0}});
  d.root["scenes"][0]["nodes"] = {0, 1, 2, 3};
  for (const double far : {1e19, -1e30, 1e308}) {
    for (const std::size_t node : {1u, 2u, 3u}) d.root["nodes"][node]["translation"] = {0, far, 0};
    const Scene scene = load(d);
    EXPECT_TRUE(scene.is_framed);
    EXPECT_EQ(warnings, (Strings{"left out: a camera that is too far away",
                                 "left out, as they are too far away: 1 light"}));
    // Where a directional light stands does not matter.
    expect_near(scene.directional_lights.at(0).direction, {0, 0, -1});
    EXPECT_TRUE(scene.point_lights.empty());
  }
  // One that looks away from the scene looks there too, however far away it is.
  for (const std::size_t node : {1u, 2u, 3u}) d.root["nodes"][node]["translation"] = {0, 0, -1e12};
  const Camera camera = load(d).camera;
  EXPECT_TRUE(warnings.empty());
  EXPECT_LT(camera.target.z, camera.position.z);
}

TEST_F(GltfSceneTest, MaterialsEmit) {
  Document d;
  d.root["materials"] = {{{"pbrMetallicRoughness", {{"metallicFactor", 0}}},
                          {"emissiveFactor", {1, 0.5, 0}},
                          {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 5}}}}}}};
  d.primitive()["material"] = 0;
  expect_near(load(d).meshes.at(0).material.emission, {5, 2.5, 0});
  EXPECT_TRUE(warnings.empty());
  d.root["materials"][0].erase("extensions");
  expect_near(load(d).meshes.at(0).material.emission, {1, 0.5, 0});
  d.root["materials"][0]["emissiveTexture"] = {{"index", 0}};
  expect_near(load(d).meshes.at(0).material.emission, {0, 0, 0});
  EXPECT_EQ(warnings.size(), 2u);
}

TEST_F(GltfSceneTest, LightsShineFromTheirNodes) {
  Document d;
  d.root["extensionsUsed"] = {"KHR_lights_punctual"};
  d.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "directional"}, {"color", {1, 0.5, 0}}, {"intensity", 4}},
      {{"type", "point"}, {"intensity", 10}, {"range", 20}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", kPi / 6}, {"outerConeAngle", kPi / 3}}}}};
  const double half = std::sqrt(0.5);
  for (int i = 0; i < 3; ++i) {
    d.root["nodes"].push_back({{"translation", {i, 2, 3}},
                               {"rotation", {-half, 0, 0, half}},  // -z becomes -y
                               {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  }
  d.root["scenes"][0]["nodes"] = {0, 1, 2, 3};
  Scene scene = load(d);
  EXPECT_EQ(expect_one_warning(), "shown without their range: 1 light");
  ASSERT_EQ(scene.directional_lights.size(), 1u);
  expect_near(scene.directional_lights[0].direction, {0, -1, 0});
  expect_near(scene.directional_lights[0].irradiance, {4, 2, 0});
  ASSERT_EQ(scene.point_lights.size(), 2u);
  expect_near(scene.point_lights[0].position, {1, 2, 3});
  expect_near(scene.point_lights[0].intensity, {10, 10, 10});
  EXPECT_EQ(scene.point_lights[0].outer_angle_degrees, 180);
  expect_near(scene.point_lights[1].axis, {0, -1, 0});
  EXPECT_NEAR(scene.point_lights[1].inner_angle_degrees, 30, 1e-4);
  EXPECT_NEAR(scene.point_lights[1].outer_angle_degrees, 60, 1e-4);

  animate(d, {{"node", 1}, {"path", "translation"}}, {0, 1}, places(d, {0, 0, 5, 4, 0, 5}));
  d.root["nodes"][2]["extensions"]["KHR_node_visibility"]["visible"] = false;
  scene = load(d);
  EXPECT_EQ(scene.point_lights.size(), 1u);
  EXPECT_EQ(expect_one_warning(),
            "standing still as when the shutter opens, although the animation moves or hides them: 1 light");

  // Points need no direction, the others do.
  d.root.erase("animations");
  d.root["nodes"][2].erase("extensions");
  for (std::size_t i = 0; i < 3; ++i) {
    d.root["nodes"][i + 1]["rotation"] = {0, 0, 0, 0};
    d.root["nodes"][i + 1]["extensions"]["KHR_lights_punctual"]["light"] = i;
  }
  scene = load(d);
  EXPECT_EQ(scene.directional_lights.size(), 0u);
  EXPECT_EQ(scene.point_lights.size(), 1u);
  EXPECT_EQ(warnings.back(), "left out, as their nodes give them no direction: 2 lights");
}

TEST_F(GltfSceneTest, CamerasStayWithinReach) {
  Document d = two_nodes();
  d.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  d.root["nodes"].push_back({{"camera", 0}, {"translation", {1.8e18, 0, 0}}});
  d.root["nodes"][3]["rotation"] = {0, -std::sqrt(0.5), 0, std::sqrt(0.5)};  // -z becomes x
  d.root["nodes"][0]["translation"] = {1.84e18, 0, 0};
  d.root["scenes"][0]["nodes"] = {0, 3};
  Camera camera = load(d).camera;
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(camera.position.x, 1.8e18f);
  EXPECT_FLOAT_EQ(camera.target.x, 1.84e18f);
  d.root["nodes"][3]["rotation"] = {0, 0, 0, 1};
  d.root["nodes"][0]["translation"] = {1e18, 1e18, -1.8e18};
  d.root["nodes"][3]["translation"] = {0, 0, 1.8e18};
  camera = load(d).camera;
  EXPECT_FLOAT_EQ(camera.target.z, -1.8e18f);
  d.root["nodes"][3]["rotation"] = {std::sin(0.4), 0, 0, std::cos(0.4)};
  camera = load(d).camera;
  EXPECT_LT(camera.target.y, 1.844e18f);
  EXPECT_GT(camera.target.y, 1e18f);
  EXPECT_NEAR(camera.target.y / (1.8e18f - camera.target.z), std::tan(0.8), 1e-3);
  d.root["nodes"][3]["rotation"] = {0, 0, 0, 0};
  load(d);
  EXPECT_EQ(expect_one_warning(), "left out: a camera that does not look anywhere");
}

TEST_F(GltfSceneTest, OneWarningForEachKindThatIsLeftOut) {
  Document d;
  d.root["extensionsUsed"] = {"KHR_materials_unlit", "EXT_node_visibility_of_others",
                              "KHR_mesh_quantization"};
  d.root["extensionsRequired"] = {"KHR_materials_unlit"};
  d.root["materials"] = {
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 1}}},
       {"alphaMode", "BLEND"}}};
  d.primitive()["material"] = 0;
  d.primitive()["attributes"]["COLOR_0"] = 0;
  json points = d.primitive();
  points["mode"] = 0;
  json bare = d.primitive();
  bare["attributes"].erase("POSITION");
  d.root["meshes"][0]["primitives"].push_back(points);
  d.root["meshes"][0]["primitives"].push_back(points);
  d.root["meshes"][0]["primitives"].push_back(bare);
  load(d);
  EXPECT_EQ(
      warnings,
      (Strings{"left out: what these extensions say: EXT_node_visibility_of_others, KHR_materials_unlit",
               "left out: 2 primitives of points or lines", "left out: 1 primitive without positions",
               "left out: the vertex colors of 1 primitive", "left out: the textures of 1 material",
               "left out: the transparency of 1 material", "left out: metal and roughness of 1 material"}));
}

TEST_F(GltfSceneTest, ScenesAreChosen) {
  Document d = two_nodes();
  d.root["scenes"] = {{{"name", "nothing"}}, {{"nodes", {0}}}, {{"name", "both"}, {"nodes", {0, 2}}}};
  const auto meshes = [&](const std::string& scene) {
    GltfOptions options;
    options.scene = scene;
    return load(d, options).meshes.size();
  };
  EXPECT_EQ(meshes(""), 1u);
  EXPECT_EQ(expect_one_warning(), "its scene 0 is empty; scene 1 is shown");
  EXPECT_EQ(meshes("2"), 2u);
  EXPECT_EQ(meshes("both"), 2u);
  EXPECT_TRUE(warnings.empty());
  d.root["scene"] = 2;
  EXPECT_EQ(meshes(""), 2u);
  EXPECT_EQ(meshes("1"), 1u);
  GltfOptions options;
  options.scene = "nothing";
  expect_refused(write("file.glb", d.bytes()), "its scene has no triangles", options);
  options.scene = "3";
  expect_refused(write("file.glb", d.bytes()),
                 "it has no scene '3'; its scenes are 0 'nothing', 1 '', 2 'both'", options);
}

TEST_F(GltfSceneTest, SparseAccessorsNeedNoView) {
  Document d;
  const int places_of_indices = d.add<std::uint8_t>("SCALAR", 5121, {1, 2});
  const int new_indices = d.add<std::uint16_t>("SCALAR", 5123, {1, 2});
  const int vertex = d.add<std::uint16_t>("SCALAR", 5123, {3});
  const int new_position = places(d, {7, 8, 9});
  d.root["accessors"].push_back({{"componentType", 5123},
                                 {"count", 3},
                                 {"type", "SCALAR"},
                                 {"sparse",
                                  {{"count", 2},
                                   {"indices", {{"bufferView", places_of_indices}, {"componentType", 5121}}},
                                   {"values", {{"bufferView", new_indices}}}}}});
  d.primitive()["indices"] = d.root["accessors"].size() - 1;
  d.root["accessors"].push_back({{"componentType", 5126},
                                 {"count", 4},
                                 {"type", "VEC3"},
                                 {"sparse",
                                  {{"count", 1},
                                   {"indices", {{"bufferView", vertex}, {"componentType", 5123}}},
                                   {"values", {{"bufferView", new_position}}}}}});
  d.primitive()["targets"] = {{{"POSITION", d.root["accessors"].size() - 1}}};
  d.root["nodes"][0]["weights"] = {1};
  const Mesh mesh = load(d).meshes.at(0);
  EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 1, 2}));
  expect_near(mesh.steps[0][2], {1, 1, 0});
  expect_near(mesh.steps[0][3], {7, 9, 9});
}

TEST_F(GltfSceneTest, DataUrisOfAnyMediaType) {
  // Twelve bytes: three vertices of bytes, the last at (0, 255, 62).
  const std::string base64 = "AAAAAAAAAAAA/z4A";
  Document d;
  d.root["bufferViews"] = {{{"buffer", 0}, {"byteLength", 12}}};
  d.root["accessors"] = {{{"bufferView", 0}, {"componentType", 5121}, {"count", 3}, {"type", "VEC3"}}};
  d.primitive().erase("indices");
  const auto last_vertex = [&](const std::string& uri) {
    d.root["buffers"] = {{{"uri", uri}, {"byteLength", 12}}};
    d.root["accessors"][0]["byteOffset"] = 2;
    d.root["accessors"][0]["count"] = 3;
    return load_file(write("uri.gltf", d.root.dump())).meshes.at(0).steps.at(0)[2];
  };
  d.root["bufferViews"][0]["byteLength"] = 12;
  for (const char* prefix :
       {"data:application/octet-stream;base64,", "data:;base64,", "data:application/gltf-buffer;base64,",
        "data:application/octet-stream;charset=utf-8;base64,", "DATA:text/plain;BASE64,",
        "data:model/gltf+json;version=2;base64,", "data:application/octet-stream; base64,",
        "data:application/octet-stream ; base64 ,", "data:a/b;name=\"x,y;z\";Base64,", "data:;base64, \n",
        "data:;base64,%20"}) {
    expect_near(last_vertex(prefix + base64), {0, 255, 62});
  }
  expect_near(last_vertex("data:;base64,AAAAAAAAAAAA_z4A"), {0, 255, 62});  // the other alphabet
  expect_near(last_vertex("data:,%00%00%00%00%00%00%00%00%00%FF>%00"), {0, 255, 62});
  const auto refused = [&](const std::string& uri, const std::string& because) {
    d.root["buffers"][0]["uri"] = uri;
    expect_refused(write("uri.gltf", d.root.dump()), because);
  };
  expect_near(last_vertex("data:;base64,AAAA\nAAAA\tAAAA\r\n /z4A "), {0, 255, 62});
  for (const char* header : {"data:a/b;base64;foo,", "data:a/b;base64;base64,", "data:a/b;base64=,",
                             "data:a/b;name=\"x;base64,", "data:;base64 x,"})
    refused(header + base64, "the data URI of buffer 0 cannot be decoded");
  refused("data:;base64", "the data URI of buffer 0 cannot be decoded");
  refused("data:;base64,AAAA*AAA", "the data URI of buffer 0 cannot be decoded");
  refused("data:;base64,AAAAA", "the data URI of buffer 0 cannot be decoded");
  refused("data:;base64,AAAA", "buffer 0 should have 12 bytes, but only 3 are there");
}

TEST_F(GltfSceneTest, BuffersThatNothingUsesMayBeMissing) {
  Document d;
  d.root["buffers"].push_back({{"byteLength", 100}});
  d.root["buffers"].push_back({{"byteLength", 100}, {"uri", "images.bin"}});
  d.root["bufferViews"].push_back({{"buffer", 2}, {"byteLength", 100}});
  EXPECT_EQ(load(d).triangle_count(), 2u);
  d.root["bufferViews"][0]["buffer"] = 1;
  expect_refused(write("used.glb", d.bytes()), "buffer 1 has no data");
  d.root["bufferViews"][0]["buffer"] = 2;
  expect_refused(write("used.glb", d.bytes()), "'images.bin', to which buffer 2 refers, does not exist");
  write("there.bin", std::string(100, '\0'));
  for (const char* uri : {"http://a/b.bin", "https://a.b?c=d", "file:///etc/hosts", "file:there.bin"}) {
    d.root["buffers"][2]["uri"] = uri;
    expect_refused(write("used.glb", d.bytes()), "buffer 2 refers to '" + std::string(uri) +
                                                     "', but only files beside it and data URIs are read");
  }
  for (const std::string& uri : {std::string("there.bin%00zz"), std::string("there.bin\0", 10)}) {
    d.root["buffers"][2]["uri"] = uri;
    expect_refused(write("used.glb", d.bytes()), "the URI of buffer 2 has a zero byte");
  }
}

TEST_F(GltfSceneTest, TrianglesThatAreNotFiniteAreCounted) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Document d;
  d.root["nodes"][0]["name"] = "sail";
  d.primitive()["attributes"]["POSITION"] = places(d, {0, 0, 0, kNan, 0, 0, 1, 1, 0, 0, 1, 0});
  Scene scene = load(d);
  EXPECT_EQ(expect_one_warning(),
            "1 triangle is left out, with vertices that are not finite or too far away: 1 of 2 in \"sail\"");
  EXPECT_EQ(scene.triangle_count(), 1u);

  // A key that is not finite takes a mesh away; not without a word, and not the others.
  for (const bool adaptive : {false, true}) {
    Document moving = two_nodes();
    animate(moving, {{"node", 0}, {"path", "translation"}}, {0, 1, 2},
            places(moving, {0, 0, 0, 5, kNan, 0, 9, 0, 0}));
    GltfOptions options{"", {}, 3};
    if (adaptive) options.largest_deviation = 1e-2;
    scene = load(moving, options);
    EXPECT_EQ(scene.meshes.size(), 1u);
    ASSERT_FALSE(warnings.empty());
    EXPECT_NE(warnings.back().find("2 of 2 in \"node 0\""), std::string::npos) << warnings.back();
  }
  d.primitive()["attributes"]["POSITION"] = places(d, {0, 0, 0, kNan, 0, 0, kNan, 1, 0, 0, 1, 0});
  expect_refused(write("nothing.glb", d.bytes()), "none of its triangles can be shown");
}

/// Of a node, of its keys, of instances: for one that is none, what it turns is left out.
TEST_F(GltfSceneTest, RotationsThatAreNoneTakeWhatTheyTurnAway) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float half = std::sqrt(0.5f);
  GltfOptions equidistant{"", {}, 5}, adaptive, keys;
  adaptive.largest_deviation = 1e-2;
  keys.at_keys = true;
  const std::string said = "left out, with vertices that are not finite or too far away: 2 of 2 in \"node 0";
  const auto expect_one_left = [&](const Document& d, const GltfOptions& options) {
    const Scene scene = load(d, options);
    EXPECT_EQ(scene.meshes.size(), 1u);
    ASSERT_FALSE(warnings.empty());
    EXPECT_NE(warnings.back().find(said), std::string::npos) << warnings.back();
  };
  for (const Floats& none :
       {Floats{std::nanf(""), 0, 0, 1}, Floats{0, 0, kInfinity, 1}, Floats{0, 0, 0, 0}}) {
    Document moving = two_nodes();
    Floats turns{0, 0, half, half};
    turns.insert(turns.end(), none.begin(), none.end());
    turns.insert(turns.end(), {0, 0, half, half});
    animate(moving, {{"node", 0}, {"path", "rotation"}}, {0, 1, 2}, moving.add<float>("VEC4", 5126, turns));
    for (const GltfOptions& options : {equidistant, adaptive, keys}) expect_one_left(moving, options);

    Document instances;
    json& attributes = instances.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    Floats two{0, 0, half, half};
    two.insert(two.end(), none.begin(), none.end());
    attributes["ROTATION"] = instances.add<float>("VEC4", 5126, two);
    expect_one_left(instances, {});
    EXPECT_NE(warnings.back().find("\"node 0 [1]\""), std::string::npos) << warnings.back();
  }
  Document still = two_nodes();
  still.root["nodes"][0]["rotation"] = {0, 0, 0, 0};
  expect_one_left(still, {});
  still.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  still.root["nodes"][0] = {{"camera", 0}, {"rotation", {0, 0, 0, 0}}};
  EXPECT_TRUE(load(still).is_framed);
  EXPECT_EQ(expect_one_warning(), "left out: a camera that does not look anywhere");
}

TEST_F(GltfSceneTest, RotationsOfAnyLengthTurn) {
  for (const double length : {1e-320, 1e-200, 0.3, 3e38, 1e200, 1.7e308}) {
    Document d;
    d.root["nodes"][0]["rotation"] = {0, 0, length, length};  // 90 degrees about z
    expect_near(load(d).meshes.at(0).steps.at(0)[1], {0, 1, 0});
    EXPECT_TRUE(warnings.empty());
  }
  Document d;
  const float most = std::numeric_limits<float>::max();
  animate(d, {{"node", 0}, {"path", "rotation"}}, {0, 1},
          d.add<float>("VEC4", 5126, {0, 0, 0, most, 0, 0, most, most}));
  expect_near(load(d, {"", {}, 3}).meshes.at(0).steps.at(1)[1], {std::sqrt(0.5), std::sqrt(0.5), 0});
}

/// A file of twice as many nodes must not take four times as long: this one would take hours.
TEST_F(GltfSceneTest, HundredsOfThousandsOfNodes) {
  const std::size_t count = 200'000;
  Document d;
  d.root["nodes"] = json::array();
  d.root["scenes"][0]["nodes"] = json::array();
  for (std::size_t i = 0; i < count; ++i) {
    d.root["nodes"].push_back({{"mesh", 0}, {"translation", {i, 0, 0}}});
    d.root["scenes"][0]["nodes"].push_back(i);
  }
  for (const std::size_t node : {std::size_t{5}, count - 1})
    animate(d, {{"node", node}, {"path", "scale"}}, {0, 1}, places(d, {1, 1, 1, 2, 2, 2}));
  const fs::path file = write("many.glb", d.bytes());
  for (const bool adaptive : {false, true}) {
    GltfOptions options;
    if (adaptive) options.largest_deviation = 1e-9;
    const Scene scene = load_file(file, options);
    ASSERT_EQ(scene.meshes.size(), count);
    EXPECT_EQ(scene.meshes[count - 2].steps.size(), 1u);
    EXPECT_EQ(scene.meshes[count - 2].steps[0][0].x, static_cast<float>(count - 2));
    EXPECT_EQ(scene.meshes[count - 1].steps.size(), adaptive ? 2u : 9u);
  }
}

TEST_F(GltfSceneTest, SharedCases) {
  if (!fs::exists(kCases)) GTEST_SKIP() << "no cases in " << kCases;
  const auto meshes = [&](const char* name) { return load_file(kCases / name).meshes.size(); };
  EXPECT_EQ(meshes("gltf_silently_incomplete/gpu_instancing_used.gltf"), 3u);
  EXPECT_EQ(meshes("gltf_silently_incomplete/node_visibility_used.gltf"), 1u);
  expect_near(load_file(kCases / "gltf_silently_incomplete/emissive.gltf").meshes.at(0).material.emission,
              {5, 5, 5});
  for (const char* name :
       {"datauri_charset", "datauri_empty_mime", "req_KHR_texture_basisu", "sparse_indices_no_view"}) {
    const fs::path file = kCases / "gltf_refused_without_need" / (std::string(name) + ".gltf");
    EXPECT_EQ(load_file(file).triangle_count(), 4u) << name;
  }
  expect_refused(kCases / "gltf_refused_without_need/int_as_float.gltf",
                 "byteOffset is 0.0, which is not a whole number");
  expect_refused(kCases / "glb_bombs/gltf_bomb_targets_300.glb", "GB with 9 steps");
  expect_refused(kCases / "glb_bombs/gltf_negative_offset_accepted.glb",
                 "bufferViews[0].byteOffset is -36, which is not a whole number from 0 on");
  load_file(kCases / "not_finite_vertices/nan_vertex.gltf");
  EXPECT_NE(expect_one_warning().find("left out, with vertices that are not finite"), std::string::npos);
}

}  // namespace
}  // namespace stbvh::harness
