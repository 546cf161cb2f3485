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
  EXPECT_NE(said("KHR_texture_basisu").find("requires KTX"), std::string::npos);
  EXPECT_NE(said("EXT_mesh_gpu_instancing").find("EXT_mesh_gpu_instancing, which is not supported"),
            std::string::npos);
  EXPECT_EQ(said("KHR_mesh_quantization"), "");
  EXPECT_EQ(said("KHR_materials_unlit"), "");
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
  refused("but no data", [&](json& d) {
    d["accessors"][0].erase("bufferView");
    d["accessors"][0]["count"] = kHuge;
  });
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
  refused("the rotation of node 0 has 3 numbers", [](json& d) { d["nodes"][0]["rotation"] = {0, 0, 1}; });
  refused("scene 3 is missing", [](json& d) { d["scene"] = 3; });
  refused("without valid attributes", [](json& d) { d["meshes"][0]["primitives"][0]["attributes"] = 1; });
  refused("glTF version 1.0", [](json& d) { d["asset"]["version"] = "1.0"; });
  refused("missing sampler 4", [](json& d) {
    d["animations"] = {{{"channels", {{{"sampler", 4}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
  });
  refused("missing sampler", [](json& d) {
    d["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 9}, {"path", "scale"}}}}}}}};
  });
  expect_refused(folder / "nowhere.glb", "the file does not exist");
  expect_refused(folder, "the file is not a regular file");
  expect_refused(write("empty.glb", ""), "it is not a glTF file");
  expect_refused(write("text.gltf", "hello"), "it is not a glTF file");
  expect_refused(write("json.gltf", "{\"asset\": {\"version\": }}"), "its JSON is broken at byte");
  expect_refused(write("deep.gltf", "{\"extras\":" + std::string(1000000, '[')),
                 "nested more than 100 levels");
  expect_refused(write("other.gltf", "{}"), "it is not a glTF file: its JSON has no asset.version");
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
