/// rtcGetSceneBounds and rtcGetSceneLinearBounds: the same floats as Embree's.
#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

void expect_same_box(const RTCBounds& own, const RTCBounds& reference) {
  EXPECT_EQ(own.lower_x, reference.lower_x);
  EXPECT_EQ(own.lower_y, reference.lower_y);
  EXPECT_EQ(own.lower_z, reference.lower_z);
  EXPECT_EQ(own.upper_x, reference.upper_x);
  EXPECT_EQ(own.upper_y, reference.upper_y);
  EXPECT_EQ(own.upper_z, reference.upper_z);
}

void expect_same_bounds(RTCScene own, RTCScene reference) {
  RTCBounds own_box, reference_box;
  ours().rtcGetSceneBounds(own, &own_box);
  native().rtcGetSceneBounds(reference, &reference_box);
  expect_same_box(own_box, reference_box);
  RTCLinearBounds own_linear, reference_linear;
  ours().rtcGetSceneLinearBounds(own, &own_linear);
  native().rtcGetSceneLinearBounds(reference, &reference_linear);
  expect_same_box(own_linear.bounds0, reference_linear.bounds0);
  expect_same_box(own_linear.bounds1, reference_linear.bounds1);
}

TEST(PreloadBounds, OfOneMeshWithAnySteps) {
  for (unsigned steps : {2u, 3u, 4u, 7u, 16u, 33u, 129u}) {
    const Mesh mesh = triangle_soup(steps, 60, steps);
    Twice twice;
    twice.add(mesh);
    twice.commit();
    EXPECT_TRUE(is_taken_over(twice.our_scene));
    expect_same_bounds(twice.our_scene, twice.native_scene);
  }
}

TEST(PreloadBounds, OfOneMeshWithAnyTimeRange) {
  Random random(7);
  for (unsigned i = 0; i < 60; ++i) {
    Mesh mesh = triangle_soup(i, 40, 2 + random.below(12));
    mesh.start_time = random.between(-0.5f, 0.8f);
    mesh.end_time = std::max(0.05f, mesh.start_time) + random.between(0.1f, 1.0f);
    Twice twice;
    twice.add(mesh);
    twice.commit();
    expect_same_bounds(twice.our_scene, twice.native_scene);
  }
}

TEST(PreloadBounds, OfSeveralMeshesWithDifferentSteps) {
  for (unsigned i = 0; i < 30; ++i) {
    const Mesh a = triangle_soup(i, 50, 3), b = triangle_soup(i + 100, 30, 8),
               c = triangle_soup(i + 200, 9, 2);
    const Mesh still = triangle_soup(i + 300, 10, 1);
    Twice twice;
    for (const Mesh* const mesh : {&a, &b, &c, &still}) twice.add(*mesh);
    twice.commit();
    EXPECT_TRUE(is_taken_over(twice.our_scene));
    expect_same_bounds(twice.our_scene, twice.native_scene);
  }
}

/// Of a mesh of few blocks of triangles, of many, and of part of one; then of each once it is the largest.
TEST(PreloadBounds, OfLargeMeshesWhenOneOfThemChanges) {
  std::vector<Mesh> meshes;
  for (const unsigned triangles : {5000u, 13000u, 20u})
    meshes.push_back(triangle_soup(triangles, triangles, 2 + triangles % 3));
  Twice twice;
  for (const Mesh& mesh : meshes) twice.add(mesh);
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  expect_same_bounds(twice.our_scene, twice.native_scene);
  float far = 2.0f;
  for (unsigned id = 0; id < meshes.size(); ++id) {
    Mesh& mesh = meshes[id];
    // The last vertex: of the last block.
    for (std::vector<Position>& positions : mesh.steps) positions[mesh.vertex_count() - 1].y = far += 1.0f;
    twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
      const RTCGeometry geometry = embree.rtcGetGeometry(scene, id);
      for (unsigned step = 0; step < mesh.steps.size(); ++step)
        embree.rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step);
      embree.rtcCommitGeometry(geometry);
    });
    twice.commit();
    expect_same_bounds(twice.our_scene, twice.native_scene);
    RTCBounds box;
    ours().rtcGetSceneBounds(twice.our_scene, &box);
    EXPECT_EQ(box.upper_y, far);
  }
}

TEST(PreloadBounds, InvalidTrianglesDoNotCount) {
  Mesh mesh = triangle_soup(3, 30, 4);
  mesh.steps[2][5].y = std::numeric_limits<float>::infinity();
  mesh.steps[1][8].x = 2e18f;
  mesh.steps[0][40].z = std::numeric_limits<float>::quiet_NaN();
  mesh.indices[60] = 90;  // out of range, though there is padding
  Twice twice;
  twice.add(mesh);
  twice.commit();
  expect_same_bounds(twice.our_scene, twice.native_scene);
}

TEST(PreloadBounds, OfInstances) {
  const Mesh mesh = triangle_soup(5, 40, 5);
  Twice twice;
  RTCScene inner[2];
  int i = 0;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    inner[i] = embree.rtcNewScene(device);
    attach(embree, inner[i], new_mesh(embree, device, mesh));
    embree.rtcCommitScene(inner[i]);
    const RTCGeometry instance = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    embree.rtcSetGeometryInstancedScene(instance, inner[i]);
    const float matrix[12] = {2, 0, 0, 0.5f, 0, 1, 0.5f, 3, 0, 0, 1, -1};
    embree.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
    attach(embree, scene, instance);
    embree.rtcReleaseScene(inner[i++]);
  });
  twice.commit();
  expect_same_bounds(twice.our_scene, twice.native_scene);
}

}  // namespace
}  // namespace stbvh::preload_test
