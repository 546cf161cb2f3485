/// Weights of morph targets: whose they are, what moves them, and how many there must be.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "tests/harness/gltf_files.h"

namespace stbvh::harness {
namespace {

class GltfWeightsTest : public AnimatedGltfTest {
 protected:
  /// A square with two targets: the first moves it by 1 along x, the second by 10.
  static Document with_targets() {
    Document d;
    for (const float x : {1.0f, 10.0f}) {
      const int offsets = d.add<float>("VEC3", 5126, {x, 0, 0, x, 0, 0, x, 0, 0, x, 0, 0});
      d.primitive()["targets"].push_back({{"POSITION", offsets}});
    }
    return d;
  }

  static void move_target(Document& d, const json& target, const Floats& weights) {
    json& animation = d.root["animations"][0];
    const int input = d.add<float>("SCALAR", 5126, {0, 1});
    const int output = d.add<float>("SCALAR", 5126, weights);
    animation["samplers"].push_back({{"input", input}, {"output", output}});
    animation["channels"].push_back({{"sampler", animation["channels"].size()}, {"target", target}});
  }

  static void move(Document& d, const std::string& pointer, const Floats& weights) {
    move_target(d, {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}},
                weights);
  }

  /// Where the first vertex of each mesh is as the shutter opens and as it closes.
  std::vector<Floats> ends(const Document& d) {
    std::vector<Floats> all;
    const Scene scene = load_gltf(write("file.glb", d.bytes()), {"", {}, 2},
                                  [](const std::string& sentence) { ADD_FAILURE() << sentence; });
    for (const Mesh& mesh : scene.meshes) all.push_back({mesh.steps.front()[0].x, mesh.steps.back()[0].x});
    return all;
  }

  void refused(const std::string& because, const std::function<void(Document&)>& change) {
    Document d = with_targets();
    change(d);
    expect_refused(write("bad.glb", d.bytes()), because);
  }
};

using Ends = std::vector<Floats>;

TEST_F(GltfWeightsTest, RestAsTheFileSaysOrAtZero) {
  Document d = with_targets();
  EXPECT_EQ(ends(d), (Ends{{0, 0}}));
  d.root["meshes"][0]["weights"] = {1, 0.5};
  EXPECT_EQ(ends(d), (Ends{{6, 6}}));
  d.root["nodes"][0]["weights"] = {0, 2};
  EXPECT_EQ(ends(d), (Ends{{20, 20}}));
}

TEST_F(GltfWeightsTest, APointerMovesOneThatRestsAtZero) {
  Document d = with_targets();
  move(d, "/nodes/0/weights/1", {0, 1});
  EXPECT_EQ(ends(d), (Ends{{0, 10}}));
  move(d, "/nodes/0/weights/0", {3, 4});
  EXPECT_EQ(ends(d), (Ends{{3, 14}}));
}

/// The second node has weights of its own, the third's are moved.
TEST_F(GltfWeightsTest, ThoseOfAMeshAreThoseOfAllNodesWithoutTheirOwn) {
  Document d = with_targets();
  d.root["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"weights", {5, 0}}}, {{"mesh", 0}}};
  d.root["scenes"][0]["nodes"] = {0, 1, 2};
  d.root["meshes"][0]["weights"] = {2, 0};
  move_target(d, {{"node", 2}, {"path", "weights"}}, {0, 0, 7, 0});
  move(d, "/meshes/0/weights/1", {0, 1});
  EXPECT_EQ(ends(d), (Ends{{2, 12}, {5, 5}, {0, 7}}));
  move(d, "/meshes/0/weights", {1, 1, 0, 2});
  EXPECT_EQ(ends(d), (Ends{{11, 20}, {5, 5}, {0, 7}}));
}

TEST_F(GltfWeightsTest, AreAsManyAsTargets) {
  refused("meshes[0] has 3 weights, but 2 morph targets", [](Document& d) {
    d.root["meshes"][0]["weights"] = {0, 0, 0};
  });
  refused("nodes[0] has 1 weights, but its mesh has 2 morph targets",
          [](Document& d) { d.root["nodes"][0]["weights"] = {0}; });
  refused("nodes[1] has 2 weights, but its mesh has 0 morph targets", [](Document& d) {
    d.root["nodes"].push_back({{"weights", {0, 0}}});
  });
  // Two keys of one weight each, and as many as there would be for one key more.
  for (const Floats& weights : {Floats{0, 1}, Floats{0, 1, 0, 1, 0, 1}}) {
    refused("(animation values) has " + std::to_string(weights.size()) + " elements, but its 2 keys need 4",
            [&](Document& d) {
              move_target(d, {{"node", 0}, {"path", "weights"}}, weights);
            });
  }
}

TEST_F(GltfWeightsTest, WithoutATargetCannotMove) {
  refused("weight 2 of node 0 is animated, but it has only 2 morph targets", [](Document& d) {
    move(d, "/nodes/0/weights/2", {0, 1});
  });
  refused("weight 7 of mesh 0 is animated, but it has only 2 morph targets", [](Document& d) {
    move(d, "/meshes/0/weights/7", {0, 1});
  });
  refused("refers to the missing mesh 3", [](Document& d) { move(d, "/meshes/3/weights", {0, 0, 1, 1}); });
  refused("the weights of node 0 are animated, but it has no morph targets", [](Document& d) {
    d.primitive().erase("targets");
    // Not in the file, and not read.
    d.root["accessors"].push_back({{"componentType", 5126}, {"count", 120'000'000}, {"type", "SCALAR"}});
    d.root["animations"][0] = {
        {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
        {"samplers", {{{"input", 0}, {"output", d.root["accessors"].size() - 1}}}}};
  });
}

}  // namespace
}  // namespace stbvh::harness
