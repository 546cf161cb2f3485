/// load_gltf() against files that are small, but ask for much memory or time; and where it still shows what
/// they mean.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/harness/gltf_files.h"

namespace stbvh::harness {
namespace {

class GltfSizeTest : public AnimatedGltfTest {
 protected:
  Scene load(const Document& d, const GltfOptions& options = {}) {
    return load_gltf(write("file.glb", d.bytes()), options);
  }

  void expect_too_large(const Document& d, const GltfOptions& options = {}) {
    expect_refused(write("bomb.glb", d.bytes()), "GB with", options);
  }

  /// Vertices that stand nowhere in the file.
  static void grow(Document& d, std::size_t vertices) {
    d.root["accessors"].push_back({{"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}});
    d.primitive()["attributes"]["POSITION"] = d.root["accessors"].size() - 1;
  }

  static void animate_pointer(Document& d, const std::string& pointer, const Floats& times, int output,
                              const std::string& interpolation) {
    json& animation = d.root["animations"][0];
    animation["samplers"].push_back({{"input", d.add<float>("SCALAR", 5126, times)},
                                     {"output", output},
                                     {"interpolation", interpolation}});
    animation["channels"].push_back(
        {{"sampler", animation["channels"].size()},
         {"target",
          {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}});
  }

  static void blink(Document& d, int node, const Floats& times, const std::vector<std::uint8_t>& visible) {
    animate_pointer(d, "/nodes/" + std::to_string(node) + "/extensions/KHR_node_visibility/visible", times,
                    d.add<std::uint8_t>("SCALAR", 5121, visible), "STEP");
  }

  /// Shown and hidden in turn, shown so many times.
  static void blink(Document& d, int node, int shown) {
    Floats times;
    std::vector<std::uint8_t> visible;
    for (int i = 0; i < 2 * shown; ++i) {
      times.push_back(static_cast<float>(i));
      visible.push_back(static_cast<std::uint8_t>(i % 2));
    }
    blink(d, node, times, visible);
  }

  /// Nodes with the mesh, each below the last.
  static Document chain(int length) {
    Document d;
    d.root["nodes"] = json::array();
    for (int i = 0; i < length; ++i) {
      d.root["nodes"].push_back({{"mesh", 0}, {"translation", {0, 1, 0}}});
      if (i + 1 < length) d.root["nodes"].back()["children"] = {i + 1};
    }
    return d;
  }

  static std::vector<GltfOptions> all_kinds_of_steps() {
    GltfOptions adaptive, keys;
    adaptive.largest_deviation = 1e-3;
    keys.at_keys = true;
    return {GltfOptions(), adaptive, keys};
  }
};

TEST_F(GltfSizeTest, EachTimeThatAMeshIsSeenCounts) {
  for (const GltfOptions& options : all_kinds_of_steps()) {
    Document d;
    grow(d, 1'000'000);
    EXPECT_EQ(load(d, options).meshes.size(), 1u);
    blink(d, 0, 200);
    expect_too_large(d, options);
    grow(d, 1'000);
    EXPECT_EQ(load(d, options).meshes.size(), 199u);  // as it is seen for the last time, the shutter closes
  }
}

TEST_F(GltfSizeTest, WhatIsBelowIsSeenWhereAllAboveIsSeen) {
  Document d = chain(4);
  blink(d, 0, {0, 1, 3, 4}, {1, 0, 1, 1});
  blink(d, 1, {0, 2, 3.5f}, {0, 1, 0});
  d.root["nodes"][3]["extensions"]["KHR_node_visibility"]["visible"] = false;
  const Scene scene = load(d);
  struct Seen {
    const char* name;
    float begin, end;
  };
  const Seen all[] = {
      {"node 0", 0, 0.25f}, {"node 0", 0.75f, 1}, {"node 1", 0.75f, 0.875f}, {"node 2", 0.75f, 0.875f}};
  ASSERT_EQ(scene.meshes.size(), std::size(all));
  for (std::size_t i = 0; i < std::size(all); ++i) {
    EXPECT_EQ(scene.meshes[i].name, all[i].name);
    EXPECT_EQ(scene.meshes[i].time_range.begin, all[i].begin);
    EXPECT_EQ(scene.meshes[i].time_range.end, all[i].end);
  }
}

TEST_F(GltfSizeTest, TimesOfNodesWithoutMeshesCountToo) {
  Document d;
  blink(d, 0, 8'000);
  const json visible = d.root["animations"][0]["channels"][0];
  for (int i = 1; i < 2'000; ++i) {
    d.root["nodes"][0]["children"].push_back(i);
    d.root["nodes"].push_back(json::object());
    json& channel = d.root["animations"][0]["channels"].emplace_back(visible);
    channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
        "/nodes/" + std::to_string(i) + "/extensions/KHR_node_visibility/visible";
  }
  EXPECT_EQ(refusal(write("file.glb", d.bytes())),
            "its nodes are shown and hidden more often than a file of its size may");
}

TEST_F(GltfSizeTest, ManyNodesWithAMeshOfManyPrimitives) {
  Document d;
  d.root["meshes"][0]["primitives"] = json(10'000, d.primitive());
  const std::size_t count = 20'000;
  d.root["nodes"] = json(count, {{"mesh", 0}});
  for (std::size_t i = 1; i < count; ++i) d.root["scenes"][0]["nodes"].push_back(i);
  expect_too_large(d);
}

TEST_F(GltfSizeTest, OfBuffersNoMoreIsReadThanTheyAreLong) {
  Document d;
  write("big.bin", d.binary);
  fs::resize_file(folder / "big.bin", std::size_t{4'000'000'000});  // takes no room on the disk
  fs::create_symlink("big.bin", folder / "link.bin");
  d.root["buffers"][0]["uri"] = "big.bin";
  const json first = d.root["buffers"][0], accessor = d.root["accessors"][0];
  for (const char* uri : {"big.bin", "./big.bin", "%62ig.bin", "link.bin"}) {
    const std::size_t number = d.root["buffers"].size();
    json& buffer = d.root["buffers"].emplace_back(first);
    buffer["uri"] = uri;
    buffer["byteLength"] = 48 + number;  // each longer than the last
    d.root["bufferViews"].push_back({{"buffer", number}, {"byteLength", 48}});
    d.root["accessors"].push_back(accessor);
    d.root["accessors"].back()["bufferView"] = d.root["bufferViews"].size() - 1;
    d.primitive()["attributes"]["POSITION"] = d.root["accessors"].size() - 1;
    EXPECT_EQ(load_gltf(write("file.gltf", d.root.dump())).meshes.at(0).steps.at(0)[2].y, 1) << uri;
  }
  // Together longer than what may be read, if there were as much.
  for (const json& whole : {json("big.bin"), json("nowhere.bin")}) {
    d.root["buffers"][0]["uri"] = whole;
    d.root["buffers"][0]["byteLength"] = std::uint64_t{1} << 60;
    EXPECT_EQ(refusal(write("file.gltf", d.root.dump())), "its buffers have more than 24 GB");
  }
}

/// What is in memory once may not make a file larger than it is.
TEST_F(GltfSizeTest, ABufferThatIsNamedOftenCountsOnce) {
  Document d;
  grow(d, 1'000'000'000);
  d.root["buffers"][0] = {{"uri", "some.bin"}, {"byteLength", 2'000'000}};
  write("some.bin", d.binary + std::string(2'000'000, '\0'));
  const json buffer = d.root["buffers"][0], view = d.root["bufferViews"][0],
             accessor = d.root["accessors"][0];
  for (std::size_t i = 1; i < 10; ++i) {
    d.root["buffers"].push_back(buffer);
    d.root["bufferViews"].push_back(view);
    d.root["bufferViews"].back()["buffer"] = i;
    d.root["accessors"].push_back(accessor);
    d.root["accessors"].back()["bufferView"] = d.root["bufferViews"].size() - 1;
  }
  const fs::path file = write("file.gltf", d.root.dump());
  const std::size_t bytes = fs::file_size(file) + 2'000'000;
  expect_refused(file, "a file of " + std::to_string(bytes) + " bytes may need");
}

/// So many targets that they are nothing in the file, but not in the poses of many nodes.
TEST_F(GltfSizeTest, WeightsOfManyNodes) {
  Document d;
  d.primitive()["targets"] = json(50'000, json::object());
  const std::size_t count = 4'000;
  d.root["nodes"] = json(count, {{"mesh", 0}});
  for (std::size_t i = 1; i < count; ++i) d.root["scenes"][0]["nodes"].push_back(i);
  expect_too_large(d);
  // Of nodes that are not in the scene too.
  d.root["scenes"][0]["nodes"] = {0};
  EXPECT_EQ(load(d).triangle_count(), 2u);
  const int output = d.add<float>("SCALAR", 5126, {0, 1});
  animate_pointer(d, "/meshes/0/weights/7", {0, 1}, output, "LINEAR");
  expect_too_large(d);
}

/// Twice as deep must not take four times as long: this would take an hour.
TEST_F(GltfSizeTest, AChainThatIsShownAndHidden) {
  const int count = 50'000;
  Document d = chain(count);
  blink(d, 0, {0, 1, 2}, {1, 0, 1});
  animate_node(d, 0, "translation", {0, 4}, {0, 1, 0, 8, 1, 0});
  const Scene scene = load(d, {"", {}, 3});
  ASSERT_EQ(scene.meshes.size(), 2u * count);
  const Mesh& last = scene.meshes.back();
  EXPECT_EQ(last.time_range.begin, 0.5f);
  ASSERT_EQ(last.steps.size(), 3u);
  EXPECT_EQ(last.steps[1][0].x, 6);
  EXPECT_EQ(last.steps[1][0].y, static_cast<float>(count));
}

TEST_F(GltfSizeTest, AChainThatFollowsOneNode) {
  const int count = 20'000;
  Document d = chain(count);
  animate_node(d, 0, "translation", {0, 1, 4}, {0, 1, 0, 8000, 1, 0, 0, 1, 0});
  for (const GltfOptions& options : all_kinds_of_steps()) {
    const Scene scene = load(d, options);
    ASSERT_EQ(scene.meshes.size(), std::size_t{count});
    const Mesh& last = scene.meshes.back();
    EXPECT_GE(last.steps.size(), 3u);
    EXPECT_EQ(last.steps.back()[0].x, 0);
    EXPECT_EQ(last.steps.back()[0].y, static_cast<float>(count));
  }
}

/// Many meshes with one skin of many joints, each of whose vertices follow two; one of them moves.
TEST_F(GltfSizeTest, MeshesThatShareASkin) {
  const int count = 10'000;
  Document d;
  d.primitive()["attributes"]["JOINTS_0"] =
      d.add<std::uint16_t>("VEC4", 5123, {7, 0, 0, 9, 7, 0, 0, 9, 7, 0, 0, 9, 7, 0, 0, 9});
  d.primitive()["attributes"]["WEIGHTS_0"] =
      d.add<float>("VEC4", 5126, {0.25f, 0, 0, 0.75f, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  d.root["nodes"] = json::array();
  for (int i = 0; i < 2 * count; ++i) {
    if (i < count) {
      d.root["skins"][0]["joints"].push_back(i);
      d.root["nodes"].push_back({{"translation", {i, 0, 0}}});
    } else {
      d.root["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
    }
    d.root["scenes"][0]["nodes"][static_cast<std::size_t>(i)] = i;
  }
  animate_node(d, 9, "translation", {0, 1, 4}, {9, 0, 0, 9, 8, 0, 9, 0, 8});
  for (const GltfOptions& options : all_kinds_of_steps()) {
    const Scene scene = load(d, options);
    ASSERT_EQ(scene.meshes.size(), std::size_t{count});
    const Mesh& last = scene.meshes.back();
    EXPECT_GE(last.steps.size(), 3u);
    EXPECT_EQ(last.steps.back()[0].x, 8.5f);  // 7 and 9
    EXPECT_EQ(last.steps.back()[0].z, 6);
    EXPECT_EQ(last.steps.back()[1].x, 8);
  }
}

/// Below and above what moves, by maps of all kinds: as a pose of the whole file has it.
TEST_F(GltfSizeTest, WhatStandsStillBetweenWhatMovesIsKept) {
  Document d = chain(8);
  const double half = std::sqrt(0.5);
  d.root["nodes"][0]["rotation"] = {0, half, 0, half};
  d.root["nodes"][1]["scale"] = {2, 3, -1};
  d.root["nodes"][3].erase("translation");
  d.root["nodes"][3]["matrix"] = {0, 1, 0, 0, 2, 0, 0, 0, 0.5, 0, 1, 0, 3, 4, 5, 1};
  d.root["nodes"][4]["rotation"] = {half, 0, 0, half};
  d.root["nodes"][6]["scale"] = {1, 0.25, 1};
  turn_by_90_degrees(d, 2);
  animate_node(d, 5, "translation", {0, 0.5f, 1}, {0, 1, 0, 5, 1, 0, 5, 9, 0});
  const auto at = [&](double time) { return load(d, {"", FilePart{time, time}, 1}); };
  const Scene begin = at(0), end = at(1);
  for (const GltfOptions& options : all_kinds_of_steps()) {
    const Scene scene = load(d, options);
    ASSERT_EQ(scene.meshes.size(), 8u);
    for (std::size_t m = 0; m < 8; ++m) {
      EXPECT_EQ(scene.meshes[m].is_static(), m < 2) << m;
      for (std::size_t v = 0; v < 4; ++v) {
        const Vec3f first = scene.meshes[m].steps.front()[v], last = scene.meshes[m].steps.back()[v];
        const Vec3f at_begin = begin.meshes[m].steps[0][v],
                    at_end = (m < 2 ? begin : end).meshes[m].steps[0][v];
        for (const auto coordinate : {&Vec3f::x, &Vec3f::y, &Vec3f::z}) {
          EXPECT_NEAR(first.*coordinate, at_begin.*coordinate, 1e-5) << m;
          EXPECT_NEAR(last.*coordinate, at_end.*coordinate, 1e-5) << m;
        }
      }
    }
  }
}

}  // namespace
}  // namespace stbvh::harness
