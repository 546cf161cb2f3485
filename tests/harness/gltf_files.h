/// What the tests of load_gltf() share: files made on the fly, and how a file is refused.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "harness/scenes/gltf/gltf.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {

using nlohmann::json;

inline const fs::path kData = fs::path(STBVH_SOURCE_DIR) / "data";
inline const fs::path kAssets = fs::path(STBVH_SOURCE_DIR) / "../shared/assets";

template <class T>
std::vector<T> as_vector(std::string_view bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

class GltfTest : public TemporaryFolderTest {};

/// The message with which a file is refused; empty if it loads. It names the file and is one line.
inline std::string refusal(const fs::path& file, const GltfOptions& options = {}) {
  try {
    load_gltf(file, options);
  } catch (const SceneFileError& error) {
    const std::string message = error.what();
    EXPECT_TRUE(message.starts_with(file.string() + ": ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message.substr(std::min(message.size(), file.string().size() + 2));
  }
  return {};
}

inline void expect_refused(const fs::path& file, const std::string& because,
                           const GltfOptions& options = {}) {
  EXPECT_NE(refusal(file, options).find(because), std::string::npos)
      << "said: " << refusal(file, options) << "\nshould say: " << because;
}

inline std::string glb(const json& document, std::string binary) {
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const auto u32 = [](std::size_t n) { return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(n)}); };
  return "glTF" + u32(2) + u32(28 + text.size() + binary.size()) + u32(text.size()) + "JSON" + text +
         u32(binary.size()) + std::string("BIN\0", 4) + binary;
}

/// One node with one mesh: a square of four vertices, and what a test adds to it.
struct Document {
  json root = json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]})");
  std::string binary;

  Document() {
    add<float>("VEC3", 5126, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3});
  }

  template <class T>
  int add(const std::string& type, int component_type, const std::vector<T>& values,
          bool normalized = false) {
    const std::size_t width = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    root["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", values.size() * sizeof(T)}});
    root["accessors"].push_back({{"bufferView", root["bufferViews"].size() - 1},
                                 {"componentType", component_type},
                                 {"normalized", normalized},
                                 {"count", values.size() / width},
                                 {"type", type}});
    binary += bytes_of(values);
    root["buffers"] = {{{"byteLength", binary.size()}}};
    return static_cast<int>(root["accessors"].size()) - 1;
  }

  json& primitive() { return root["meshes"][0]["primitives"][0]; }
  std::string bytes() const { return glb(root, binary); }
};

using Floats = std::vector<float>;

/// With keys for what the square does.
class AnimatedGltfTest : public GltfTest {
 protected:
  /// Adds keys for a property of `node`.
  static void animate_node(Document& d, int node, const std::string& path, const Floats& times,
                           const Floats& values, const std::string& interpolation = "LINEAR") {
    json& animation = d.root["animations"][0];
    const int input = d.add<float>("SCALAR", 5126, times);
    const int output = d.add<float>(path == "rotation" ? "VEC4" : "VEC3", 5126, values);
    animation["channels"].push_back(
        {{"sampler", animation["channels"].size()}, {"target", {{"node", node}, {"path", path}}}});
    animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
  }

  /// Along x, from key to key.
  static Document sliding(const Floats& times, const Floats& x, const std::string& interpolation = "LINEAR") {
    Document d;
    Floats values;
    for (const float place : x) values.insert(values.end(), {place, 0, 0});
    animate_node(d, 0, "translation", times, values, interpolation);
    return d;
  }

  static void turn_by_90_degrees(Document& d, int node) {
    const float half = std::sqrt(0.5f);
    animate_node(d, node, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half});
  }
};

/// Our files, as parameters of tests.
inline const auto kOwnFiles =
    testing::Values("bending_tube", "morphing_sphere", "propeller", "quantised_flag");

}  // namespace stbvh::harness
