// References, in all orders of release. Run under AddressSanitizer to be worth its name.
#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

bool is_hit(RTCScene scene) {
  return intersect(scene, ray_down(.1f, .1f, .5f)).hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

class PluginLifetime : public testing::Test {
 protected:
  void SetUp() override {
    geometry_ = own_geometry(device_, meshes_);
    scene_ = new_scene(device_);
    rtcAttachGeometry(scene_.get(), stbvhGetGeometry(geometry_.get()));
    rtcCommitScene(scene_.get());
    ASSERT_TRUE(is_hit(scene_.get()));
  }

  std::vector<TestMesh> meshes_{flat_triangle(0, 5), flat_triangle(-1, 3)};
  Device device_ = new_device();
  Scene scene_;
  OwnGeometry geometry_;
};

TEST_F(PluginLifetime, SceneFirst) {
  scene_.reset();
  geometry_.reset();
}

TEST_F(PluginLifetime, HandleFirstThenTheSceneHitsNothing) {
  geometry_.reset();
  meshes_.clear();  // the buffers are the application's again
  EXPECT_FALSE(is_hit(scene_.get()));
  EXPECT_FALSE(is_occluded(scene_.get(), ray_down(.1f, .1f, .5f)));
  rtcCommitScene(scene_.get());
  EXPECT_FALSE(is_hit(scene_.get()));
  const TestMesh other = flat_triangle(3);
  rtcAttachGeometry(scene_.get(), native_geometry(device_, other).get());
  rtcCommitScene(scene_.get());
  EXPECT_TRUE(is_hit(scene_.get()));
  EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_NONE);
}

TEST_F(PluginLifetime, DeviceFirst) {
  device_.reset();
  EXPECT_TRUE(is_hit(scene_.get()));
  EXPECT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  scene_.reset();
  EXPECT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  geometry_.reset();
}

TEST_F(PluginLifetime, EmbreesGeometryLast) {
  const RTCGeometry rtc_geometry = stbvhGetGeometry(geometry_.get());
  rtcRetainGeometry(rtc_geometry);
  const NativeGeometry kept(rtc_geometry);
  scene_.reset();
  geometry_.reset();
  const Scene other = new_scene(device_);
  rtcAttachGeometry(other.get(), kept.get());
  rtcCommitScene(other.get());
  EXPECT_FALSE(is_hit(other.get()));
}

TEST_F(PluginLifetime, ReferencesAreCounted) {
  stbvhRetainGeometry(geometry_.get());
  stbvhReleaseGeometry(geometry_.get());
  EXPECT_TRUE(is_hit(scene_.get()));
  stbvhRetainGeometry(geometry_.get());
  const OwnGeometry second(geometry_.get());
  geometry_.reset();
  EXPECT_TRUE(is_hit(scene_.get()));
}

TEST_F(PluginLifetime, BelowAnInstanceWhoseSceneIsReleased) {
  Scene top = new_scene(device_);
  {
    const NativeGeometry instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(instance.get(), scene_.get());
    const float identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    rtcSetGeometryTransform(instance.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, identity);
    rtcCommitGeometry(instance.get());
    rtcAttachGeometry(top.get(), instance.get());
  }
  rtcCommitScene(top.get());
  scene_.reset();
  EXPECT_TRUE(is_hit(top.get()));
  geometry_.reset();
  EXPECT_FALSE(is_hit(top.get()));
}

TEST_F(PluginLifetime, DetachedAndAttachedAgain) {
  rtcDetachGeometry(scene_.get(), 0);
  rtcCommitScene(scene_.get());
  EXPECT_FALSE(is_hit(scene_.get()));
  rtcAttachGeometry(scene_.get(), stbvhGetGeometry(geometry_.get()));
  rtcCommitScene(scene_.get());
  EXPECT_TRUE(is_hit(scene_.get()));
}

TEST_F(PluginLifetime, DisabledAndEnabled) {
  rtcDisableGeometry(stbvhGetGeometry(geometry_.get()));
  rtcCommitScene(scene_.get());
  EXPECT_FALSE(is_hit(scene_.get()));
  rtcEnableGeometry(stbvhGetGeometry(geometry_.get()));
  rtcCommitScene(scene_.get());
  EXPECT_TRUE(is_hit(scene_.get()));
}

}  // namespace
}  // namespace stbvh::test
