/// Animations of many frames, and scenes that are edited.
#include "harness/scenes/frames.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "harness/scenes/scene_editor.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/test_scenes.h"

namespace stbvh::harness {
namespace {

Scene small_scene() {
  Pcg32 random(3);
  Scene scene;
  scene.name = "small";
  for (const std::size_t steps : {5u, 1u, 3u, 9u, 2u, 4u})
    scene.meshes.push_back(wandering_triangles(40, steps, random));
  return scene;
}

bool same(const VertexBuffer& a, const VertexBuffer& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].x != b[i].x || a[i].y != b[i].y || a[i].z != b[i].z) return false;
  }
  return a.size() == b.size();
}

TEST(Frames, GoForwardsAndBackwards) {
  const Scene shutter = small_scene();
  const Scene animation = played(shutter, 3);
  ASSERT_EQ(animation.meshes.size(), shutter.meshes.size());
  EXPECT_EQ(animation.meshes[0].steps.size(), 13u);
  EXPECT_EQ(animation.meshes[1].steps.size(), 1u);
  const Scene second = frame_of(shutter, 1);
  for (std::size_t i = 0; i < shutter.meshes.size(); ++i) {
    const Mesh &given = shutter.meshes[i], &mesh = second.meshes[i];
    ASSERT_EQ(mesh.steps.size(), given.steps.size());
    for (std::size_t k = 0; k < mesh.steps.size(); ++k)
      EXPECT_TRUE(same(mesh.steps[k], given.steps[given.steps.size() - 1 - k]));
    EXPECT_TRUE(same(frame_of(shutter, 2).meshes[i].steps[0], given.steps[0]));
  }
  for (std::size_t frame = 0; frame < 3; ++frame) {
    const Scene one = frame_of(shutter, frame);
    for (std::size_t i = 0; i < shutter.meshes.size(); ++i) {
      const std::vector<VertexBuffer>& steps = one.meshes[i].steps;
      const std::size_t first = frame * (steps.size() - 1);
      for (std::size_t k = 0; k < steps.size(); ++k)
        EXPECT_TRUE(same(animation.meshes[i].steps[first + k], steps[k]));
    }
  }
  Scene late = shutter;
  late.meshes[0].time_range = {0.5f, 1.0f};
  EXPECT_THROW(played(late, 2), SceneFileError);
  EXPECT_THROW(played(shutter, 600), SceneFileError);  // 4,801 steps
}

TEST(Frames, InPiecesMoveAlike) {
  const Scene animation = played(small_scene(), 40);
  const Scene pieces = in_pieces(animation);
  EXPECT_EQ(pieces.meshes.size(), 6u + 1u + 2u);  // 161 steps are two pieces, 321 three
  for (const Mesh& mesh : pieces.meshes) EXPECT_LE(mesh.steps.size(), kMaxSceneSteps);
  const auto whole = build_structure("stbvh-direct", animation, 1),
             parts = build_structure("stbvh-direct", pieces, 1);
  Pcg32 random(5);
  std::size_t hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto coordinate = [&] { return static_cast<float>(random.uniform(0, 10)); };
    const Vec3f from{coordinate(), coordinate(), -20};
    const Ray ray{from, 0, {0, 0, 1}, static_cast<float>(random.uniform()), 100};
    Hit a{}, b{};
    const bool hit = whole->intersect_one(ray, a);
    if (hit != parts->intersect_one(ray, b)) continue;  // beside an edge, within the rounding of the time
    hits += hit ? 1u : 0u;
    if (hit) {
      EXPECT_NEAR(a.t, b.t, 1e-3f);
    }
  }
  EXPECT_GT(hits, 100u);
}

/// After any edits an updated structure, ours or Embree's, answers as one that is built anew.
TEST(SceneEditor, EditsAreFollowed) {
  Scene scene = small_scene();
  SceneEditor editor(scene, 1);
  const auto embree = build_structure("embree", scene, 1), ours = build_structure("stbvh", scene, 1);
  for (const char* const name : {"embree", "embree-4v", "stbvh", "stbvh-16"}) EXPECT_TRUE(is_updatable(name));
  for (const char* const name : {"lbvh", "stbvh-beside", "stbvh-direct"}) EXPECT_FALSE(is_updatable(name));
  Pcg32 random(9);
  for (std::size_t i = 0; i < 60; ++i) {
    SCOPED_TRACE("edit " + std::to_string(i));
    const std::vector<MeshEdit> edits = editor.apply(static_cast<EditKind>(i % edit_kind_names().size()));
    ASSERT_FALSE(edits.empty());
    for (StructureUnderTest* const structure : {embree.get(), ours.get()}) structure->update(scene, edits);
    const auto embree_anew = build_structure("embree", scene, 1),
               ours_anew = build_structure("stbvh", scene, 1);
    for (int k = 0; k < 200; ++k) {
      const auto coordinate = [&] { return static_cast<float>(random.uniform(0, 10)); };
      const Ray ray{
          {coordinate(), coordinate(), -20}, 0, {0, 0, 1}, static_cast<float>(random.uniform()), 100};
      Hit a{}, b{};
      ASSERT_EQ(ours->intersect_one(ray, a), ours_anew->intersect_one(ray, b));
      ASSERT_EQ(a.t, b.t);
      Hit c{}, d{};
      ASSERT_EQ(embree->intersect_one(ray, c), embree_anew->intersect_one(ray, d));
      ASSERT_EQ(c.t, d.t);
    }
  }
}

TEST(SceneEditor, IsTheSameForTheSameSeed) {
  Scene a = small_scene(), b = small_scene();
  SceneEditor first(a, 4), second(b, 4);
  for (std::size_t i = 0; i < 30; ++i) {
    first.apply(static_cast<EditKind>(i % 6));
    second.apply(static_cast<EditKind>(i % 6));
  }
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i].indices, b.meshes[i].indices);
    EXPECT_EQ(a.meshes[i].mask, b.meshes[i].mask);
    EXPECT_TRUE(same(a.meshes[i].steps[0], b.meshes[i].steps[0]));
  }
  Scene empty;
  EXPECT_TRUE(SceneEditor(empty, 1).apply(EditKind::kMoved).empty());
}

}  // namespace
}  // namespace stbvh::harness
