// Hit data as Embree's own triangles give it.
#include <algorithm>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

TEST(PluginHitData, OneMeshOfEachStepCount) {
  const Device device = new_device();
  for (const unsigned steps : {1u, 2u, 3u, 5u, 9u, 17u, 129u}) {
    SCOPED_TRACE(testing::Message() << steps << " steps");
    const std::vector<TestMesh> meshes{triangle_soup(steps, 300, steps)};
    const ScenePair pair = scene_pair(device, meshes);
    expect_same_hits(pair.native.get(), pair.own.get(), 2000, steps);
  }
}

TEST(PluginHitData, MeshesWithDifferentStepCountsInOneGeometry) {
  const Device device = new_device();
  std::vector<TestMesh> meshes;
  for (const unsigned steps : {2u, 1u, 6u, 15u, 9u, 1u, 129u})
    meshes.push_back(triangle_soup(static_cast<std::uint32_t>(meshes.size()), 60, steps));
  const ScenePair pair = scene_pair(device, meshes);
  expect_same_hits(pair.native.get(), pair.own.get(), 6000, 1);
}

TEST(PluginHitData, GeometriesOfThePluginBesideEmbreesOwn) {
  const Device device = new_device();
  const std::vector<TestMesh> moving{triangle_soup(1, 80, 5), triangle_soup(2, 80, 4)};
  const std::vector<TestMesh> still{triangle_soup(3, 80, 1)};
  const std::vector<TestMesh> others{triangle_soup(4, 80, 1), triangle_soup(5, 80, 3)};
  const Scene native = new_scene(device), own = new_scene(device);
  const OwnGeometry moving_geometry = own_geometry(device, moving);
  OwnGeometry still_geometry(stbvhNewGeometry(device.get()));
  std::vector<const void*> pointers;
  const StbvhMeshArguments arguments =
      arguments_of(still[0], pointers);  // geomID: the one it is attached under
  ASSERT_EQ(stbvhAddMesh(still_geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(still_geometry.get()), RTC_ERROR_NONE);
  rtcAttachGeometryByID(own.get(), stbvhGetGeometry(moving_geometry.get()), 10);
  rtcAttachGeometryByID(own.get(), stbvhGetGeometry(still_geometry.get()), 2);
  rtcAttachGeometryByID(native.get(), native_geometry(device, moving[0]).get(), 0);
  rtcAttachGeometryByID(native.get(), native_geometry(device, moving[1]).get(), 1);
  rtcAttachGeometryByID(native.get(), native_geometry(device, still[0]).get(), 2);
  for (unsigned i = 0; i < 2; ++i) {
    rtcAttachGeometryByID(native.get(), native_geometry(device, others[i]).get(), 3 + i);
    rtcAttachGeometryByID(own.get(), native_geometry(device, others[i]).get(), 3 + i);
  }
  rtcCommitScene(native.get());
  rtcCommitScene(own.get());
  expect_same_hits(native.get(), own.get(), 4000, 2);
}

TEST(PluginHitData, SeveralScenesShareAGeometryUnderTheirOwnIds) {
  const Device device = new_device();
  const TestMesh mesh = triangle_soup(6, 200, 5);
  OwnGeometry geometry(stbvhNewGeometry(device.get()));
  std::vector<const void*> pointers;
  const StbvhMeshArguments arguments = arguments_of(mesh, pointers);
  ASSERT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  for (const unsigned id : {0u, 5u, 123u}) {
    const Scene native = new_scene(device), own = new_scene(device);
    rtcAttachGeometryByID(native.get(), native_geometry(device, mesh).get(), id);
    rtcAttachGeometryByID(own.get(), stbvhGetGeometry(geometry.get()), id);
    rtcCommitScene(native.get());
    rtcCommitScene(own.get());
    expect_same_hits(native.get(), own.get(), 1000, id);
  }
}

TEST(PluginHitData, StridesOfTheApplication) {
  const Device device = new_device();
  const TestMesh mesh = triangle_soup(8, 200, 3);
  const ScenePair pair = scene_pair(device, {mesh});
  // The same positions 16 and 32 bytes apart, the same indices 20 bytes apart.
  std::vector<std::vector<float>> steps;
  const std::size_t strides[3] = {12, 16, 32};
  for (std::size_t step = 0; step < 3; ++step) {
    std::vector<float>& data = steps.emplace_back(mesh.vertex_count() * strides[step] / 4, -9.0f);
    for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
      std::copy_n(&mesh.steps[step][i].x, 3, &data[i * strides[step] / 4]);
    }
  }
  std::vector<std::uint32_t> indices(mesh.indices.size() / 3 * 5, 0xFFFFFFFFu);
  for (std::size_t t = 0; t < mesh.indices.size() / 3; ++t) {
    std::copy_n(&mesh.indices[3 * t], 3, &indices[5 * t]);
  }
  std::vector<const void*> pointers;
  StbvhMeshArguments arguments = arguments_of(mesh, pointers);
  for (std::size_t step = 0; step < 3; ++step) pointers[step] = steps[step].data();
  arguments.vertexByteStrides = strides;
  arguments.indices = indices.data();
  arguments.indexByteStride = 20;
  OwnGeometry geometry(stbvhNewGeometry(device.get()));
  ASSERT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  const Scene own = new_scene(device);
  rtcAttachGeometryByID(own.get(), stbvhGetGeometry(geometry.get()), 0);
  rtcCommitScene(own.get());
  expect_same_hits(pair.native.get(), own.get(), 1000, 8);
}

TEST(PluginHitData, InvalidTrianglesAreLeftOutAsByEmbree) {
  const Device device = new_device();
  std::vector<TestMesh> meshes{triangle_soup(9, 200, 5)};
  TestMesh& mesh = meshes[0];
  mesh.steps[2][30].x = std::numeric_limits<float>::quiet_NaN();
  mesh.steps[4][61].y = std::numeric_limits<float>::infinity();
  mesh.steps[0][93].z = 2e18f;
  mesh.indices[100] = 600;
  mesh.indices[200] = 0xFFFFFFFFu;
  const ScenePair pair = scene_pair(device, meshes);
  expect_same_hits(pair.native.get(), pair.own.get(), 3000, 9);
  StbvhStatistics statistics;
  stbvhInitStatistics(&statistics);
  ASSERT_EQ(stbvhGetStatistics(pair.geometry.get(), &statistics), RTC_ERROR_NONE);
  EXPECT_EQ(statistics.triangles, 195u);
  EXPECT_EQ(statistics.invalidTriangles, 5u);
  EXPECT_EQ(statistics.primitiveSegments, 195u * 4);
}

TEST(PluginHitData, MasksOfMeshesAndRays) {
  const Device device = new_device();
  std::vector<TestMesh> meshes;
  const unsigned masks[] = {1u, 2u, 4u, 0x80000000u, 0u, 6u};
  for (unsigned i = 0; i < 6; ++i) {
    meshes.push_back(triangle_soup(20 + i, 60, i % 2 == 0 ? 1 : 4));
    meshes.back().mask = masks[i];
  }
  const ScenePair pair = scene_pair(device, meshes);
  Random random(20);
  unsigned hits = 0;
  for (unsigned i = 0; i < 4000; ++i) {
    RTCRayHit ray = random_ray(random);
    const unsigned of_rays[] = {0u, 1u, 2u, 3u, 8u, 0x80000000u, 0xFFFFFFFFu};
    ray.ray.mask = of_rays[random.below(7)];
    const RTCRayHit native = intersect(pair.native.get(), ray);
    ASSERT_NO_FATAL_FAILURE(expect_same_hit(native, intersect(pair.own.get(), ray)));
    ASSERT_EQ(native.hit.geomID != RTC_INVALID_GEOMETRY_ID, is_occluded(pair.own.get(), ray));
    hits += native.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  EXPECT_GT(hits, 400u);
}

TEST(PluginHitData, AMeshWithoutAMaskHasEmbreesDefault) {
  const Device device = new_device();
  const TestMesh mesh = flat_triangle(0, 3);
  std::vector<const void*> pointers;
  StbvhMeshArguments arguments = arguments_of(mesh, pointers);
  StbvhMeshArguments defaults;
  stbvhInitMeshArguments(&defaults);
  arguments.mask = defaults.mask;
  const OwnGeometry geometry(stbvhNewGeometry(device.get()));
  ASSERT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  const NativeGeometry triangles(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetSharedGeometryBuffer(triangles.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             mesh.steps[0].data(), 0, sizeof(Position), mesh.vertex_count());
  rtcSetSharedGeometryBuffer(triangles.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(),
                             0, 12, 1);
  rtcCommitGeometry(triangles.get());
  const Scene native = new_scene(device), own = new_scene(device);
  rtcAttachGeometryByID(native.get(), triangles.get(), 0);
  rtcAttachGeometryByID(own.get(), stbvhGetGeometry(geometry.get()), 0);
  rtcCommitScene(native.get());
  rtcCommitScene(own.get());
  for (const unsigned mask : {0u, 1u, 2u, 3u, 0x80000000u, 0xFFFFFFFFu}) {
    RTCRayHit ray = ray_down(.1f, .1f, .3f);
    ray.ray.mask = mask;
    SCOPED_TRACE(testing::Message() << "mask " << mask);
    expect_same_hit(intersect(native.get(), ray), intersect(own.get(), ray));
  }
}

TEST(PluginHitData, BothSidesAreHit) {
  const Device device = new_device();
  const std::vector<TestMesh> meshes{flat_triangle(0, 2)};
  const ScenePair pair = scene_pair(device, meshes);
  RTCRayHit ray = ray_down(.1f, .1f, .3f);
  expect_same_hit(intersect(pair.native.get(), ray), intersect(pair.own.get(), ray));
  ray.ray.org_z = -10;
  ray.ray.dir_z = 1;
  expect_same_hit(intersect(pair.native.get(), ray), intersect(pair.own.get(), ray));
  EXPECT_EQ(intersect(pair.own.get(), ray).ray.tfar, 10);
}

TEST(PluginHitData, TheIntervalOfTheRayIsEmbrees) {
  const Device device = new_device();
  const ScenePair pair = scene_pair(device, {flat_triangle(0, 2)});
  const float far = std::numeric_limits<float>::infinity();
  const float ends[][2] = {{0, 10},         {0, 9.9999f}, {0, 10.0001f}, {9.9999f, far},
                           {10.0001f, far}, {10, far},    {10, 10}};
  for (const auto& [tnear, tfar] : ends) {
    RTCRayHit ray = ray_down(.1f, .1f, .3f);
    ray.ray.tnear = tnear;
    ray.ray.tfar = tfar;
    SCOPED_TRACE(testing::Message() << tnear << " to " << tfar);
    expect_same_hit(intersect(pair.native.get(), ray), intersect(pair.own.get(), ray));
  }
}

}  // namespace
}  // namespace stbvh::test
