/// The tree as the preview draws it.
#include <gtest/gtest.h>

#include <algorithm>

#include "harness/preview/tree_view.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

class TreeViewTest : public ::testing::Test {
 protected:
  const Scene scene = mixed_step_scene();
  const std::unique_ptr<StructureUnderTest> structure = build_structure("stbvh-direct", scene, 2);
  const Structure& tree = *structure->tree();
};

TEST_F(TreeViewTest, BoxesOfDeeperLevelsLieInThoseAbove) {
  // Bounds of a shorter time are tighter at its centre, and may reach out a little elsewhere.
  const auto holds = [](const Box3f& a, const Box3f& b) {
    const float slack = 0.05f * (a.upper.x - a.lower.x);
    return a.lower.x <= b.lower.x + slack && a.lower.y <= b.lower.y + slack &&
           a.lower.z <= b.lower.z + slack && a.upper.x >= b.upper.x - slack &&
           a.upper.y >= b.upper.y - slack && a.upper.z >= b.upper.z - slack;
  };
  const TreeLevel root = boxes_at(tree, 0, 0.5f);
  ASSERT_EQ(root.boxes.size(), 1u);
  EXPECT_FALSE(root.boxes[0].is_timed);
  std::size_t before = 1, timed = 0;
  for (std::size_t level = 1; level < 5; ++level) {
    const TreeLevel found = boxes_at(tree, level, 0.5f);
    EXPECT_TRUE(found.is_complete);
    EXPECT_GT(found.boxes.size(), before);
    before = found.boxes.size();
    for (const TreeBox& box : found.boxes) {
      EXPECT_TRUE(holds(root.boxes[0].box, box.box));
      EXPECT_TRUE(box.time_range.begin <= 0.5f && box.time_range.end >= 0.5f);
      timed += box.is_timed ? 1 : 0;
    }
  }
  EXPECT_GT(timed, 0u);
  // Meshes that are there for a part of the time have no boxes before it.
  EXPECT_LT(boxes_at(tree, 30, 0.05f).boxes.size(), boxes_at(tree, 30, 0.5f).boxes.size());
}

TEST_F(TreeViewTest, DrawsEdgesWhereTheCameraSeesThem) {
  TreeBox box;
  box.box = {{4, 4, 4}, {6, 6, 6}};
  Image image{64, 64, std::vector<std::uint8_t>(3 * 64 * 64)};
  const auto drawn = [&image] {
    return std::count_if(image.rgb.begin(), image.rgb.end(), [](std::uint8_t b) { return b != 0; }) / 3;
  };
  Camera camera{.position = {5, 5, 30}, .target = {5, 5, 60}};
  draw_boxes(image, {box}, camera);
  EXPECT_EQ(drawn(), 0) << "it is behind the camera";
  camera.target = {5, 5, 5};
  draw_boxes(image, {box}, camera);
  EXPECT_GT(drawn(), 16);
  EXPECT_LT(drawn(), 300);
  image.rgb.assign(image.rgb.size(), 0);
  camera.position = {5, 5, 5.5f};  // inside: all edges behind it are cut off
  camera.target = {5, 5, 0};
  camera.vertical_fov_degrees = 100;
  draw_boxes(image, {box}, camera);
  EXPECT_GT(drawn(), 16);
}

TEST_F(TreeViewTest, FindsTheLeafOfATriangleAndItsTimeLine) {
  Pcg32 random(3);
  int found = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 target{random.uniform(1, 9), random.uniform(1, 9), random.uniform(1, 9)};
    const Vec3 origin{5, 5, 30};
    const auto time = static_cast<float>(random.uniform());
    const Ray ray{.origin = to_float(origin),
                  .tnear = 0,
                  .direction = to_float(target - origin),
                  .time = time,
                  .tfar = 100,
                  .mask = 0xFFFFFFFFu};
    Hit hit;
    if (!tree.intersect(ray, hit)) continue;
    ++found;
    const Vec3 point = origin + static_cast<double>(hit.t) * (target - origin);
    const TreePath path = path_to(tree, hit.mesh, hit.prim_id, time, point);
    ASSERT_FALSE(path.empty());
    TimeRange above{0, 1};
    for (std::size_t level = 0; level <= path.size(); ++level) {
      const TimeLine line = time_line(tree, path, level, 2, 2);
      EXPECT_GE(line.subtree.time_range.begin, above.begin);
      EXPECT_LE(line.subtree.time_range.end, above.end);
      above = line.subtree.time_range;
      EXPECT_TRUE(above.begin <= time && time <= above.end);
      ASSERT_FALSE(line.nodes.empty());
      for (const TimeLineNode& node : line.nodes) EXPECT_LE(node.at_begin[0], node.at_begin[1]);
    }
    const TimeLine leaf = time_line(tree, path, path.size(), 2, 0);
    ASSERT_EQ(leaf.nodes.size(), 1u);
    EXPECT_TRUE(is_leaf(leaf.nodes[0].kind));
  }
  EXPECT_GT(found, 50);
}

}  // namespace
}  // namespace stbvh::harness
