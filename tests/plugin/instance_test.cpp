// Below instances, with and without motion transforms.
#include <cmath>

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

}  // namespace
}  // namespace stbvh::test
