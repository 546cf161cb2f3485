/// load_gltf() against files that are wrong in every way.
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "tests/harness/gltf_files.h"

namespace stbvh::harness {
namespace {

TEST_F(GltfTest, RequiredExtensions) {
  const auto said = [&](const std::string& extension) {
    Document d;
    d.root["extensionsRequired"] = {extension};
    return refusal(write("extension.glb", d.bytes()));
  };
  EXPECT_NE(said("KHR_draco_mesh_compression").find("requires Draco"), std::string::npos);
  EXPECT_NE(said("EXT_meshopt_compression").find("requires meshopt"), std::string::npos);
  EXPECT_NE(said("MPEG_accessor_timed").find("MPEG_accessor_timed, which is not supported"),
            std::string::npos);
  for (const char* name : {"KHR_mesh_quantization",
                           "EXT_mesh_gpu_instancing",
                           "KHR_node_visibility",
                           "KHR_animation_pointer",
                           "KHR_lights_punctual",
                           "KHR_materials_unlit",
                           "KHR_materials_pbrSpecularGlossiness",
                           "ADOBE_materials_thin_transparency",
                           "KHR_texture_basisu",
                           "KHR_texture_transform",
                           "EXT_texture_webp",
                           "MSFT_texture_dds",
                           "MSFT_packing_normalRoughnessMetallic",
                           "EXT_lights_image_based",
                           "KHR_techniques_webgl",
                           "MOZ_lightmap",
                           "KHR_node_hoverability",
                           "KHR_node_selectability",
                           "EXT_structural_metadata",
                           "EXT_mesh_features",
                           "EXT_instance_features",
                           "FB_ngon_encoding",
                           "CESIUM_primitive_outline"}) {
    EXPECT_EQ(said(name), "") << name;
  }
}

TEST_F(GltfTest, BadFiles) {
  const auto refused = [&](const std::string& because, const std::function<void(json&)>& change) {
    Document d;
    change(d.root);
    expect_refused(write("bad.glb", d.bytes()), because);
  };
  const auto kHuge = std::numeric_limits<std::uint64_t>::max();
  refused("reaches beyond its buffer view", [](json& d) { d["accessors"][0]["count"] = 5; });
  refused("reaches beyond its buffer view", [&](json& d) { d["accessors"][0]["count"] = kHuge; });
  refused("reaches beyond its buffer view", [&](json& d) { d["accessors"][0]["count"] = kHuge / 12 + 2; });
  refused("reaches beyond its buffer view", [&](json& d) { d["accessors"][0]["byteOffset"] = kHuge - 3; });
  refused("reaches beyond the", [&](json& d) { d["bufferViews"][0]["byteOffset"] = kHuge - 3; });
  refused("reaches beyond the", [](json& d) { d["bufferViews"][0]["byteLength"] = 1000; });
  refused("a stride of 8 bytes", [](json& d) { d["bufferViews"][0]["byteStride"] = 8; });
  refused("missing buffer 7", [](json& d) { d["bufferViews"][0]["buffer"] = 7; });
  refused("missing buffer view 9", [](json& d) { d["accessors"][0]["bufferView"] = 9; });
  refused("unknown component type", [](json& d) { d["accessors"][0]["componentType"] = 5124; });
  refused("elements of 1 components instead of 3", [](json& d) { d["accessors"][0]["type"] = "SCALAR"; });
  refused("has the index 3, but there are only 3 vertices", [](json& d) { d["accessors"][0]["count"] = 3; });
  refused("has a sparse value for element", [](json& d) {
    d["accessors"][0]["sparse"] = {{"count", 4},
                                   {"indices", {{"bufferView", 0}, {"componentType", 5125}}},
                                   {"values", {{"bufferView", 0}}}};
  });
  refused("but only", [](json& d) { d["buffers"][0]["byteLength"] = 1 << 30; });
  refused("form a cycle", [](json& d) {
    d["nodes"] = {{{"mesh", 0}}, {{"children", {2}}}, {{"children", {1}}}};
  });
  refused("more than one node", [](json& d) {
    d["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
  });
  refused("missing node 5", [](json& d) { d["nodes"][0]["children"] = {5}; });
  refused("missing mesh 5", [](json& d) { d["nodes"][0]["mesh"] = 5; });
  refused("skin 2 is missing", [](json& d) { d["nodes"][0]["skin"] = 2; });
  refused("nodes[0].rotation has 3 numbers instead of 4", [](json& d) {
    d["nodes"][0]["rotation"] = {0, 0, 1};
  });
  refused("scene 3 is missing", [](json& d) { d["scene"] = 3; });
  refused("meshes[0].primitives[0].attributes is 1, which is not an object",
          [](json& d) { d["meshes"][0]["primitives"][0]["attributes"] = 1; });
  refused("mesh 0 refers to the missing material 5",
          [](json& d) { d["meshes"][0]["primitives"][0]["material"] = 5; });
  refused("glTF version 1.0", [](json& d) { d["asset"]["version"] = "1.0"; });
  for (const char* version : {"2", "2.", ".0", "2.x", "2.0.1", "two\n"}) {
    for (const char* name : {"version", "minVersion"})
      refused("is not two numbers with a point", [&](json& d) { d["asset"][name] = version; });
  }
  refused("it needs glTF version 2.5", [](json& d) { d["asset"]["minVersion"] = "2.5"; });
  refused("it needs glTF version 3.0", [](json& d) { d["asset"]["minVersion"] = "3.0"; });
  refused("missing sampler 4", [](json& d) {
    d["animations"] = {{{"channels", {{{"sampler", 4}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
  });
  refused("missing sampler", [](json& d) {
    d["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 9}, {"path", "scale"}}}}}}}};
  });
  refused("missing mesh 5", [](json& d) { d["nodes"][0]["mesh"] = 5; });
  refused("missing camera 2", [](json& d) { d["nodes"][0]["camera"] = 2; });
  expect_refused(folder / "nowhere.glb", "the file does not exist");
  expect_refused(folder, "the file is not a regular file");
  expect_refused(write("empty.glb", ""), "it is not a glTF file");
  expect_refused(write("text.gltf", "hello"), "it is not a glTF file");
  expect_refused(write("json.gltf", "{\"asset\": {\"version\": }}"), "its JSON is broken at byte");
  expect_refused(write("deep.gltf", "{\"asset\":" + std::string(1000000, '[')),
                 "nested more than 100 levels");
  expect_refused(write("deep.gltf", "{\"extras\":" + std::string(1000000, '[')),
                 "its JSON is broken at byte");
  expect_refused(write("other.gltf", "{}"), "it is not a glTF file: its JSON has no asset.version");
}

/// Every number of a file in turn: a value of another type or out of range is refused with its place.
TEST_F(GltfTest, NumbersOfTheWrongTypeOrRange) {
  struct Place {
    const char* pointer;
    const char* named;
  };
  const Place places[] = {
      {"/accessors/0/bufferView", "accessors[0].bufferView"},
      {"/accessors/0/byteOffset", "accessors[0].byteOffset"},
      {"/accessors/0/componentType", "accessors[0].componentType"},
      {"/accessors/0/count", "accessors[0].count"},
      {"/bufferViews/0/buffer", "bufferViews[0].buffer"},
      {"/bufferViews/0/byteOffset", "bufferViews[0].byteOffset"},
      {"/bufferViews/0/byteLength", "bufferViews[0].byteLength"},
      {"/bufferViews/0/byteStride", "bufferViews[0].byteStride"},
      {"/buffers/0/byteLength", "buffers[0].byteLength"},
      {"/nodes/0/mesh", "nodes[0].mesh"},
      {"/nodes/0/skin", "nodes[0].skin"},
      {"/nodes/0/children/0", "nodes[0].children[0]"},
      {"/meshes/0/primitives/0/indices", "meshes[0].primitives[0].indices"},
      {"/meshes/0/primitives/0/material", "meshes[0].primitives[0].material"},
      {"/meshes/0/primitives/0/mode", "meshes[0].primitives[0].mode"},
      {"/meshes/0/primitives/0/attributes/POSITION", "meshes[0].primitives[0].attributes.POSITION"},
      {"/scene", "scene"},
      {"/scenes/0/nodes/0", "scenes[0].nodes[0]"}};
  for (const Place& place : places) {
    for (const json& wrong : {json(-1), json(-36), json(4.0), json(0.5), json(1e300), json("0"), json(true),
                              json(nullptr), json::array({0})}) {
      Document d;
      d.root[json::json_pointer(place.pointer)] = wrong;
      expect_refused(write("wrong.glb", d.bytes()), std::string(place.named) + " is ");
    }
  }
  Document d;
  d.root["accessors"][0]["count"] = 4.0;
  EXPECT_EQ(refusal(write("float.glb", d.bytes())),
            "accessors[0].count is 4.0, which is not a whole number from 0 on");
  for (const char* name : {"translation", "scale", "rotation", "matrix", "weights"}) {
    for (const json& wrong : {json(1), json("1"), json::array({"a", 0, 0}), json::array({nullptr})}) {
      Document other;
      other.root["nodes"][0][name] = wrong;
      expect_refused(write("wrong.glb", other.bytes()), std::string("nodes[0].") + name);
    }
  }
}

TEST_F(GltfTest, LightsAndCamerasThatCannotBe) {
  const auto refused = [&](const std::string& because, const std::function<void(json&)>& change) {
    Document d;
    change(d.root);
    expect_refused(write("bad.glb", d.bytes()), because);
  };
  refused("cameras[0].perspective.yfov is 4,", [](json& d) {
    d["nodes"][0]["camera"] = 0;
    d["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 4.0}}}}};
  });
  refused("cameras[0] is neither perspective nor", [](json& d) {
    d["nodes"][0]["camera"] = 0;
    d["cameras"] = {{{"type", "fisheye"}}};
  });
  const auto light = [](const json& source) {
    return [source](json& d) {
      d["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
      d["extensions"]["KHR_lights_punctual"]["lights"] = {source};
    };
  };
  refused("lights[0].type is the unknown \"area\"", light({{"type", "area"}}));
  refused("is not light", light({{"type", "point"}, {"intensity", -1}}));
  refused("is not light", light({{"type", "point"}, {"intensity", 1e300}}));
  refused("range is -1", light({{"type", "point"}, {"range", -1}}));
  refused("has a cone from 1", light({{"type", "spot"}, {"spot", {{"innerConeAngle", 1}}}}));
  refused("missing light 3",
          [](json& d) { d["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 3; });
  refused("is not light", [](json& d) {
    d["meshes"][0]["primitives"][0]["material"] = 0;
    d["materials"] = {{{"emissiveFactor", {0, -1, 0}}}};
  });
}

/// Small files that ask for gigabytes, in each of the ways there are, together and alone.
TEST_F(GltfTest, WhatIsNotInTheFileIsNotAllocated) {
  const auto refused = [&](const std::function<void(Document&)>& change) {
    Document d;
    change(d);
    expect_refused(write("bomb.glb", d.bytes()), "GB with");
  };
  const auto without_data = [](Document& d, const std::string& type, std::uint64_t count) {
    d.root["accessors"].push_back({{"componentType", 5126}, {"count", count}, {"type", type}});
    return static_cast<int>(d.root["accessors"].size()) - 1;
  };
  const auto channel = [](Document& d, int node, int input, int output) {
    json& animation = d.root["animations"][0];
    animation["channels"].push_back(
        {{"sampler", animation["channels"].size()}, {"target", {{"node", node}, {"path", "translation"}}}});
    animation["samplers"].push_back({{"input", input}, {"output", output}});
  };
  for (const std::uint64_t count : {std::uint64_t{1} << 27, std::uint64_t{1} << 62, ~std::uint64_t{0}}) {
    refused([&](Document& d) { d.primitive()["attributes"]["POSITION"] = without_data(d, "VEC3", count); });
  }
  refused([&](Document& d) {  // three hundred morph targets, none of which would be too much
    const int target = without_data(d, "VEC3", 1 << 20);
    d.primitive()["attributes"]["POSITION"] = target;
    d.primitive()["targets"] = json(300, {{"POSITION", target}});
  });
  refused([&](Document& d) {  // keys
    const int times = without_data(d, "SCALAR", 1 << 20), values = without_data(d, "VEC3", 1 << 20);
    for (int i = 0; i < 100; ++i) channel(d, 0, times, values);
  });
  refused([&](Document& d) {  // instances
    d.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        without_data(d, "VEC3", 4 << 20);
  });
  refused([&](Document& d) {  // joints
    d.root["skins"] = {{{"joints", {0}}, {"inverseBindMatrices", without_data(d, "MAT4", 16 << 20)}}};
    d.root["nodes"][0]["skin"] = 0;
  });
  refused([&](Document& d) {  // steps of all nodes
    d.primitive()["attributes"]["POSITION"] = without_data(d, "VEC3", 1 << 14);
    d.root["nodes"] = json(2000, {{"mesh", 0}});
    d.root["scenes"][0]["nodes"] = json::array();
    for (int i = 0; i < 2000; ++i) d.root["scenes"][0]["nodes"].push_back(i);
    const int times = d.add<float>("SCALAR", 5126, {0, 1}),
              values = d.add<float>("VEC3", 5126, {0, 0, 0, 1, 0, 0});
    for (int i = 0; i < 2000; ++i) channel(d, i, times, values);
  });
  refused([&](Document& d) {  // sparse, without anything to be sparse in
    const int places = d.add<std::uint32_t>("SCALAR", 5125, {0});
    const int values = d.add<float>("VEC3", 5126, {0, 0, 0});
    const int positions = without_data(d, "VEC3", std::uint64_t{1} << 40);
    d.root["accessors"][static_cast<std::size_t>(positions)]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", places}, {"componentType", 5125}}},
        {"values", {{"bufferView", values}}}};
    d.primitive()["attributes"]["POSITION"] = positions;
  });
  // What was refused is large; this is not.
  Document small;
  small.primitive()["attributes"]["POSITION"] = without_data(small, "VEC3", 1 << 10);
  EXPECT_EQ(load_gltf(write("small.glb", small.bytes())).triangle_count(), 2u);
}

TEST_F(GltfTest, NestingIsRefusedOrRead) {
  const std::size_t levels = 200'000;
  for (const char* where : {"asset", "nodes", "meshes", "KHR_lights_punctual"}) {
    const std::string text = std::string("{\"asset\": {\"version\": \"2.0\"}, \"") + where + "\": ";
    expect_refused(write("arrays.gltf", text + std::string(levels, '[') + std::string(levels, ']') + "}"),
                   "nested more than 100 levels");
    std::string objects;
    for (std::size_t i = 0; i < levels; ++i) objects += "{\"a\":";
    expect_refused(write("objects.gltf", text + objects + "0" + std::string(levels, '}') + "}"),
                   "nested more than 100 levels");
  }
  Document d;  // a chain, with the mesh at its end
  const int depth = 100'000;
  d.root["nodes"] = json::array();
  for (int i = 0; i < depth; ++i)
    d.root["nodes"].push_back({{"children", {i + 1}}, {"translation", {0.5, 0, 0}}});
  d.root["nodes"].push_back({{"mesh", 0}});
  const Scene scene = load_gltf(write("chain.glb", d.bytes()));
  EXPECT_EQ(scene.meshes.at(0).steps.at(0)[0].x, 0.5f * depth);
  d.root["nodes"][depth] = {{"mesh", 0}, {"children", {0}}};
  expect_refused(write("cycle.glb", d.bytes()), "form a cycle");
  d.root["nodes"][depth].erase("children");
  d.root["nodes"][1]["children"] = {1};
  expect_refused(write("self.glb", d.bytes()), "node 1 is the child of more than one node");
}

TEST_F(GltfTest, EveryPrefixIsRefused) {
  const std::string whole = read_file(kData / "propeller.glb");
  for (std::size_t length = 0; length < whole.size(); length += length < 64 ? 1 : 37) {
    EXPECT_NE(refusal(write("prefix.glb", whole.substr(0, length))), "") << length << " bytes";
  }
}

class MutationTest : public GltfTest, public testing::WithParamInterface<const char*> {};

/// Changed bytes, also with the length in the header put right again after a cut: loads or is refused, never
/// crashes.
TEST_P(MutationTest, LoadsOrIsRefused) {
  const std::string whole = read_file(kData / (std::string(GetParam()) + ".glb"));
  const std::size_t json_end = 20 + as_vector<std::uint32_t>(whole.substr(12, 4)).at(0);
  std::mt19937 random(2024);
  const auto below = [&](std::size_t n) { return random() % n; };
  const std::string digits = "0123456789-,.[]{}\"e";
  std::size_t refused = 0;
  for (int round = 0; round < 300; ++round) {
    std::string bytes = whole;
    for (std::size_t i = 0, n = 1 + below(4); i < n; ++i) {
      switch (below(3)) {
        case 0:  // a digit of the JSON: another index, count, type or offset
          if (const std::size_t at = bytes.find_first_of("0123456789", 20 + below(json_end - 20));
              at < json_end) {
            bytes[at] = digits[below(10)];
          }
          break;
        case 1:
          bytes[20 + below(json_end - 20)] = digits[below(digits.size())];
          break;
        default:
          bytes[below(bytes.size())] = static_cast<char>(below(256));
      }
    }
    refused += !refusal(write("mutated.glb", bytes), {"", {}, 3}).empty();
  }
  EXPECT_GT(refused, 30u);
  EXPECT_LT(refused, 300u);
}

INSTANTIATE_TEST_SUITE_P(Data, MutationTest, kOwnFiles,
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace stbvh::harness
