#include <gtest/gtest.h>

#include "stbvh/structure.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

std::vector<std::vector<Box3f>> step_bounds_of(std::vector<test::TestMesh> meshes) {
  std::vector<MeshView> views;
  for (test::TestMesh& mesh : meshes) views.push_back(mesh.view());
  std::vector<std::vector<Box3f>> bounds;
  BuildCallbacks callbacks;
  callbacks.step_bounds = [&](std::size_t mesh, std::vector<Box3f> steps, std::span<const float>) {
    EXPECT_EQ(mesh, bounds.size());
    bounds.push_back(std::move(steps));
  };
  Structure::build(views, {}, callbacks);
  return bounds;
}

void expect_equal(const Box3f& a, const Box3f& b) {
  EXPECT_EQ(a.lower.x, b.lower.x);
  EXPECT_EQ(a.lower.y, b.lower.y);
  EXPECT_EQ(a.lower.z, b.lower.z);
  EXPECT_EQ(a.upper.x, b.upper.x);
  EXPECT_EQ(a.upper.y, b.upper.y);
  EXPECT_EQ(a.upper.z, b.upper.z);
}

/// A soup whose outermost vertices belong to triangles that are left out, or to none.
test::TestMesh soup_with_invalid_triangles(std::size_t steps) {
  test::TestMesh mesh = test::soup(300, steps, 1);
  mesh.positions.back()[0] = {50, 50, 50};
  mesh.positions.front()[1].y = std::numeric_limits<float>::quiet_NaN();
  mesh.positions.front()[6] = {-50, 0, 0};
  mesh.indices[6] = 5000;
  return mesh;
}

/// Of the vertices of all triangles but the first and the third.
Box3f exact_box(const std::vector<Vec3f>& step) {
  Box3f box = Box3f::empty();
  for (std::size_t i = 3; i < step.size(); ++i) {
    if (i < 6 || i >= 9) box.extend(step[i]);
  }
  return box;
}

TEST(StepBounds, AreThoseOfTheValidTriangles) {
  for (const std::size_t steps : {1u, 2u, 7u, 129u}) {
    const test::TestMesh mesh = soup_with_invalid_triangles(steps);
    test::TestMesh late = mesh;  // never alive in [0, 1]
    late.time_range = {2.0f, 3.0f};
    const auto bounds = step_bounds_of({mesh, late});
    ASSERT_EQ(bounds.size(), 2u);
    for (const std::vector<Box3f>& boxes : bounds) {
      ASSERT_EQ(boxes.size(), steps);
      for (std::size_t i = 0; i < steps; ++i) expect_equal(boxes[i], exact_box(mesh.positions[i]));
    }
  }
}

TEST(StepBounds, AreEmptyWithoutValidTriangles) {
  test::TestMesh invalid = test::soup(10, 3, 1);
  for (Vec3f& p : invalid.positions[1]) p.x = std::numeric_limits<float>::infinity();
  test::TestMesh empty = test::soup(10, 3, 1);
  empty.indices.clear();
  for (const std::vector<Box3f>& boxes : step_bounds_of({invalid, empty})) {
    ASSERT_FALSE(boxes.empty());
    for (const Box3f& box : boxes) expect_equal(box, Box3f::empty());
  }
}

}  // namespace
}  // namespace stbvh
