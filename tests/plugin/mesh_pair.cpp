#include "tests/plugin/mesh_pair.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace stbvh::test {

TestMesh triangle_soup(std::uint32_t seed, unsigned triangles, unsigned step_count) {
  Random random(seed);
  TestMesh mesh;
  mesh.steps.assign(step_count, {});
  for (unsigned t = 0; t < triangles; ++t) {
    const Position center{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    for (unsigned corner = 0; corner < 3; ++corner) {
      mesh.indices.push_back(3 * t + corner);
      Position p{center.x + random.between(-.3f, .3f), center.y + random.between(-.3f, .3f),
                 center.z + random.between(-.3f, .3f)};
      for (auto& step : mesh.steps) {
        step.push_back(p);
        const float reach = .4f / static_cast<float>(step_count);
        p = {p.x + random.between(-reach, reach), p.y + random.between(-reach, reach),
             p.z + random.between(0, reach)};
      }
    }
  }
  for (auto& step : mesh.steps) step.push_back({0, 0, 0});
  return mesh;
}

TestMesh large_mesh_far_away() {
  TestMesh mesh = triangle_soup(99, 12000, 5);
  for (auto& step : mesh.steps) {
    for (Position& p : step) p.x += 1e5f;
  }
  return mesh;
}

TestMesh flat_triangle(float z, unsigned step_count) {
  TestMesh mesh;
  mesh.indices = {0, 1, 2};
  mesh.steps.assign(step_count, {{-1, -1, z}, {1, -1, z}, {0, 1, z}, {0, 0, 0}});
  return mesh;
}

StbvhMeshArguments arguments_of(const TestMesh& mesh, std::vector<const void*>& pointers) {
  pointers.clear();
  for (const auto& step : mesh.steps) pointers.push_back(step.data());
  StbvhMeshArguments arguments;
  stbvhInitMeshArguments(&arguments);
  arguments.indices = mesh.indices.data();
  arguments.triangleCount = mesh.indices.size() / 3;
  arguments.vertices = pointers.data();
  arguments.vertexCount = mesh.vertex_count();
  arguments.stepCount = static_cast<unsigned>(mesh.steps.size());
  arguments.startTime = mesh.start_time;
  arguments.endTime = mesh.end_time;
  arguments.mask = mesh.mask;
  arguments.userPtr = mesh.user_ptr;
  arguments.intersectFilter = mesh.intersect_filter;
  arguments.occludedFilter = mesh.occluded_filter;
#if RTC_VERSION_MAJOR >= 4
  arguments.enableFilterFunctionFromArguments = mesh.takes_query_filters;
#endif
  return arguments;
}

Device new_device() {
  return Device(rtcNewDevice(nullptr));
}

Scene new_scene(const Device& device) {
  Scene scene(rtcNewScene(device.get()));
  rtcSetSceneFlags(scene.get(), kSceneTakesQueryFilters);
  return scene;
}

NativeGeometry native_geometry(const Device& device, const TestMesh& mesh) {
  NativeGeometry geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  RTCGeometry g = geometry.get();
  rtcSetGeometryTimeStepCount(g, static_cast<unsigned>(mesh.steps.size()));
  for (unsigned step = 0; step < mesh.steps.size(); ++step) {
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, mesh.steps[step].data(), 0,
                               sizeof(Position), mesh.vertex_count());
  }
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0, 12,
                             mesh.indices.size() / 3);
  rtcSetGeometryTimeRange(g, mesh.start_time, mesh.end_time);
  rtcSetGeometryMask(g, mesh.mask);
  rtcSetGeometryUserData(g, mesh.user_ptr);
  rtcSetGeometryIntersectFilterFunction(g, mesh.intersect_filter);
  rtcSetGeometryOccludedFilterFunction(g, mesh.occluded_filter);
#if RTC_VERSION_MAJOR >= 4
  rtcSetGeometryEnableFilterFunctionFromArguments(g, mesh.takes_query_filters);
#endif
  rtcCommitGeometry(g);
  return geometry;
}

OwnGeometry own_geometry(const Device& device, const std::vector<TestMesh>& meshes) {
  OwnGeometry geometry(stbvhNewGeometry(device.get()));
  std::vector<const void*> pointers;
  for (unsigned i = 0; i < meshes.size(); ++i) {
    StbvhMeshArguments arguments = arguments_of(meshes[i], pointers);
    arguments.geomID = i;
    unsigned index = ~0u;
    EXPECT_EQ(stbvhAddMesh(geometry.get(), &arguments, &index), RTC_ERROR_NONE);
    EXPECT_EQ(index, i);
  }
  EXPECT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE) << stbvhGetErrorMessage(geometry.get());
  return geometry;
}

ScenePair scene_pair(const Device& device, std::vector<TestMesh> meshes) {
  ScenePair pair{std::move(meshes), new_scene(device), new_scene(device), nullptr};
  pair.geometry = own_geometry(device, pair.meshes);
  for (unsigned i = 0; i < pair.meshes.size(); ++i) {
    rtcAttachGeometryByID(pair.native.get(), native_geometry(device, pair.meshes[i]).get(), i);
  }
  rtcAttachGeometryByID(pair.own.get(), stbvhGetGeometry(pair.geometry.get()), 77);
  rtcCommitScene(pair.native.get());
  rtcCommitScene(pair.own.get());
  EXPECT_EQ(rtcGetDeviceError(device.get()), RTC_ERROR_NONE);
  return pair;
}

RTCRayHit random_ray(Random& random) {
  RTCRayHit query{};
  RTCRay& ray = query.ray;
  const Position target{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
  ray.org_x = random.between(-3, 3);
  ray.org_y = random.between(-3, 3);
  ray.org_z = random.between(0, 1) < .5f ? 3.0f : -3.0f;
  ray.dir_x = target.x - ray.org_x;
  ray.dir_y = target.y - ray.org_y;
  ray.dir_z = target.z - ray.org_z;
  ray.tnear = random.below(4) == 0 ? random.between(.3f, 1) : 0;
  ray.tfar = random.below(4) == 0 ? random.between(1, 2) : std::numeric_limits<float>::infinity();
  ray.time = random.below(4) == 0 ? static_cast<float>(random.below(9)) / 8 : random.unit();
  ray.mask = 0xFFFFFFFFu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

RTCRayHit ray_down(float x, float y, float time) {
  RTCRayHit query{};
  query.ray.org_x = x;
  query.ray.org_y = y;
  query.ray.org_z = 10;
  query.ray.dir_z = -1;
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.time = time;
  query.ray.mask = 0xFFFFFFFFu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

RTCRayHit intersect(RTCScene scene, RTCRayHit ray, const QueryOptions& options) {
  intersect_one(scene, ray, options);
  return ray;
}

/// By what an any-hit query left of the ray: nothing but tfar may have changed.
static bool was_occluded(const RTCRay& before, RTCRay after) {
  const bool occluded = after.tfar != before.tfar;
  EXPECT_EQ(after.tfar, occluded ? -std::numeric_limits<float>::infinity() : before.tfar);
  after.tfar = before.tfar;
  EXPECT_EQ(std::memcmp(&after, &before, sizeof after), 0);
  return occluded;
}

bool is_occluded(RTCScene scene, const RTCRayHit& query, const QueryOptions& options) {
  RTCRay ray = query.ray;
  occluded_one(scene, ray, options);
  return was_occluded(query.ray, ray);
}

RTCRayHit intersect_directly(StbvhGeometry geometry, RTCRayHit ray, const QueryOptions& options) {
  intersect_one(geometry, ray, options);
  return ray;
}

bool is_occluded_directly(StbvhGeometry geometry, const RTCRayHit& query, const QueryOptions& options) {
  RTCRay ray = query.ray;
  occluded_one(geometry, ray, options);
  return was_occluded(query.ray, ray);
}

bool same_bits(const RTCRayHit& a, const RTCRayHit& b) {
  return std::memcmp(&a, &b, kRayHitMembers * sizeof(float)) == 0;
}

void expect_same_hit(const RTCRayHit& native, const RTCRayHit& own) {
  ASSERT_EQ(native.hit.geomID, own.hit.geomID);
  if (native.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    ASSERT_EQ(native.ray.tfar, own.ray.tfar);
    return;
  }
  ASSERT_EQ(native.hit.primID, own.hit.primID)
      << "at distances " << native.ray.tfar << " and " << own.ray.tfar << ", u, v " << native.hit.u << ", "
      << native.hit.v << " and " << own.hit.u << ", " << own.hit.v;
  ASSERT_EQ(native.hit.instID[0], own.hit.instID[0]);
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  ASSERT_EQ(native.hit.instPrimID[0], own.hit.instPrimID[0]);
#endif
  EXPECT_NEAR(native.ray.tfar, own.ray.tfar, 1e-4f * (1 + std::fabs(native.ray.tfar)));
  EXPECT_NEAR(native.hit.u, own.hit.u, 1e-3f);
  EXPECT_NEAR(native.hit.v, own.hit.v, 1e-3f);
  const float length = std::hypot(native.hit.Ng_x, native.hit.Ng_y, native.hit.Ng_z);
  EXPECT_NEAR(native.hit.Ng_x, own.hit.Ng_x, 1e-4f * length);
  EXPECT_NEAR(native.hit.Ng_y, own.hit.Ng_y, 1e-4f * length);
  EXPECT_NEAR(native.hit.Ng_z, own.hit.Ng_z, 1e-4f * length);
}

void expect_same_hits(RTCScene native, RTCScene own, unsigned count, std::uint32_t seed) {
  Random random(seed);
  unsigned hits = 0;
  for (unsigned i = 0; i < count; ++i) {
    const RTCRayHit ray = random_ray(random);
    const RTCRayHit expected = intersect(native, ray);
    SCOPED_TRACE(testing::Message() << "ray " << i << " at time " << ray.ray.time);
    expect_same_hit(expected, intersect(own, ray));
    if (testing::Test::HasFatalFailure()) return;
    const bool hit = expected.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    ASSERT_EQ(hit, is_occluded(own, ray));
    hits += hit;
  }
  EXPECT_GT(hits, count / 10);
  EXPECT_LT(hits, count);
}

}  // namespace stbvh::test
