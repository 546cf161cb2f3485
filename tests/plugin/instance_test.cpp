// Below instances, with and without motion transforms.
#include <algorithm>
#include <cmath>
#include <set>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

/// Instances of `scene` with IDs 0 to 2: fixed, moving in two segments, and moving in a part of the shutter.
Scene scene_of_instances(const Device& device, RTCScene scene) {
  Scene top = new_scene(device);
  for (unsigned id = 0; id < 3; ++id) {
    const NativeGeometry instance(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    const unsigned steps = id == 0 ? 1 : 3;
    rtcSetGeometryInstancedScene(instance.get(), scene);
    rtcSetGeometryTimeStepCount(instance.get(), steps);
    if (id == 2) rtcSetGeometryTimeRange(instance.get(), .25f, .75f);
    for (unsigned step = 0; step < steps; ++step) {
      const float angle = .4f * static_cast<float>(step + id), scale = .6f + .1f * static_cast<float>(id);
      const float c = scale * std::cos(angle), s = scale * std::sin(angle);
      const float x = .5f * static_cast<float>(id) - .5f, y = .3f * static_cast<float>(step);
      const float transform[12] = {c, s, 0, -s, c, 0, 0, 0, scale, x, y, .1f * static_cast<float>(id)};
      rtcSetGeometryTransform(instance.get(), step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
    }
    rtcCommitGeometry(instance.get());
    rtcAttachGeometryByID(top.get(), instance.get(), id);
  }
  rtcCommitScene(top.get());
  return top;
}

TEST(PluginInstances, WithMotionTransforms) {
  const Device device = new_device();
  const std::vector<TestMesh> moving{triangle_soup(1, 100, 5), triangle_soup(2, 60, 1),
                                     triangle_soup(3, 60, 8)};
  const std::vector<TestMesh> still{triangle_soup(4, 200, 1)};
  for (const auto& meshes : {moving, still}) {
    const ScenePair pair = scene_pair(device, meshes);
    const Scene native = scene_of_instances(device, pair.native.get());
    const Scene own = scene_of_instances(device, pair.own.get());
    expect_same_hits(native.get(), own.get(), 4000, 1);
  }
}

TEST(PluginInstances, ReleasedRightAfterInstancing) {
  const Device device = new_device();
  const std::vector<TestMesh> meshes{triangle_soup(1, 200, 5)};
  ScenePair pair = scene_pair(device, meshes);
  const Scene native = scene_of_instances(device, pair.native.get());
  const Scene own = scene_of_instances(device, pair.own.get());
  pair.native.reset();
  pair.own.reset();
  expect_same_hits(native.get(), own.get(), 1000, 2);
}

#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)

/// An array of twelve instances of two scenes, moving in two segments.
Scene scene_of_instance_array(const Device& device, RTCScene even, RTCScene odd) {
  constexpr unsigned kCount = 12, kSteps = 3;
  const NativeGeometry array(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE_ARRAY));
  RTCScene scenes[] = {even, odd};
  rtcSetGeometryInstancedScenes(array.get(), scenes, 2);
  auto* const of_scenes = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      array.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(unsigned), kCount));
  for (unsigned i = 0; i < kCount; ++i) of_scenes[i] = i % 2;
  rtcSetGeometryTimeStepCount(array.get(), kSteps);
  for (unsigned step = 0; step < kSteps; ++step) {
    auto* const transforms = static_cast<float*>(
        rtcSetNewGeometryBuffer(array.get(), RTC_BUFFER_TYPE_TRANSFORM, step,
                                RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, 12 * sizeof(float), kCount));
    for (unsigned i = 0; i < kCount; ++i) {
      const float x = .6f * static_cast<float>(i % 4) - 1, y = .6f * static_cast<float>(i / 4) - 1;
      const float z = .1f * static_cast<float>(step);
      const float transform[12] = {.4f, 0, 0, 0, .4f, 0, 0, 0, .4f, x, y, z};
      std::copy(transform, transform + 12, transforms + 12 * i);
    }
  }
  rtcCommitGeometry(array.get());
  Scene top = new_scene(device);
  rtcAttachGeometryByID(top.get(), array.get(), 3);
  rtcCommitScene(top.get());
  EXPECT_EQ(rtcGetDeviceError(device.get()), RTC_ERROR_NONE);
  return top;
}

TEST(PluginInstances, InAnArrayTellWhichOneWasHit) {
  const Device device = new_device();
  const ScenePair even = scene_pair(device, {triangle_soup(1, 100, 5), triangle_soup(2, 60, 1)});
  const ScenePair odd = scene_pair(device, {triangle_soup(3, 100, 1)});
  const Scene native = scene_of_instance_array(device, even.native.get(), odd.native.get());
  const Scene own = scene_of_instance_array(device, even.own.get(), odd.own.get());
  expect_same_hits(native.get(), own.get(), 4000, 3);
  Random random(4);
  std::set<unsigned> hit_instances;
  for (unsigned round = 0; round < 500; ++round) {
    alignas(16) const int valid[4] = {-1, -1, -1, -1};
    RTCRayHit4 packet{};
    RTCRayHit rays[4];
    for (unsigned lane = 0; lane < 4; ++lane) {
      rays[lane] = random_ray(random);
      for (unsigned m = 0; m < kRayHitMembers; ++m) {
        reinterpret_cast<float*>(&packet)[4 * m + lane] = reinterpret_cast<const float*>(&rays[lane])[m];
      }
    }
    intersect_packet(valid, own.get(), packet);
    for (unsigned lane = 0; lane < 4; ++lane) {
      const RTCRayHit hit = rtcGetRayHitFromRayHitN(reinterpret_cast<RTCRayHitN*>(&packet), 4, lane);
      ASSERT_NO_FATAL_FAILURE(expect_same_hit(intersect(native.get(), rays[lane]), hit));
      if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      EXPECT_EQ(hit.hit.instID[0], 3u);
      hit_instances.insert(hit.hit.instPrimID[0]);
    }
  }
  EXPECT_EQ(hit_instances.size(), 12u);
}

#endif

}  // namespace
}  // namespace stbvh::test
