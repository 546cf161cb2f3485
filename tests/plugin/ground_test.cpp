// Rays that leave a large ground do not meet it, through Embree as without it.
#include <cmath>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

/// Two triangles over [-size, size]^2 at y = 0, with two equal steps.
TestMesh ground(float size) {
  TestMesh mesh;
  mesh.indices = {0, 1, 2, 0, 2, 3};
  mesh.steps.assign(2, {{-size, 0, -size}, {size, 0, -size}, {size, 0, size}, {-size, 0, size}, {}});
  return mesh;
}

TEST(PluginGround, IsNotMetByRaysThatLeaveIt) {
  const Device device = new_device();
  Random random(1);
  for (const float size : {10.0f, 1e3f, 1e4f, 1e5f, 1e6f}) {
    const std::vector<TestMesh> meshes{ground(size)};
    const OwnGeometry geometry = own_geometry(device, meshes);
    const Scene scene = new_scene(device);
    rtcAttachGeometry(scene.get(), stbvhGetGeometry(geometry.get()));
    rtcCommitScene(scene.get());
    for (const float height : {0.0f, 1e-4f, 1e-3f, 1e-2f}) {
      for (int i = 0; i < 5000; ++i) {
        RTCRayHit ray = ray_down(0.9f * random.between(-size, size), 0, random.unit());
        ray.ray.org_y = height;
        ray.ray.org_z = 0.9f * random.between(-size, size);
        ray.ray.dir_x = random.between(-1, 1);
        ray.ray.dir_y = random.between(1e-6f, 1);
        ray.ray.dir_z = random.between(-1, 1);
        ASSERT_EQ(intersect(scene.get(), ray).hit.geomID, RTC_INVALID_GEOMETRY_ID) << size << " " << height;
        ASSERT_FALSE(is_occluded(scene.get(), ray));
      }
    }
  }
}

}  // namespace
}  // namespace stbvh::test
