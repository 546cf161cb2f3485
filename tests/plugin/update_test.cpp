// Changes after the first commit.
#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

class PluginUpdates : public testing::Test {
 protected:
  /// Commits geometry and scene, and compares with Embree over the same meshes built anew.
  void expect_as_new(std::uint32_t seed) {
    ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
    rtcCommitScene(own_.get());
    const Scene native = new_scene(device_);
    for (unsigned i = 0; i < meshes_.size(); ++i) {
      rtcAttachGeometryByID(native.get(), native_geometry(device_, meshes_[i]).get(), i);
    }
    rtcCommitScene(native.get());
    expect_same_hits(native.get(), own_.get(), 1500, seed);
  }

  void set(unsigned index) {
    std::vector<const void*> pointers;
    StbvhMeshArguments arguments = arguments_of(meshes_[index], pointers);
    arguments.geomID = index;
    ASSERT_EQ(stbvhSetMesh(geometry_.get(), index, &arguments), RTC_ERROR_NONE);
  }

  void SetUp() override { rtcAttachGeometry(own_.get(), stbvhGetGeometry(geometry_.get())); }

  Device device_ = new_device();
  std::vector<TestMesh> meshes_{triangle_soup(1, 100, 5), triangle_soup(2, 100, 1)};
  Scene own_ = new_scene(device_);
  OwnGeometry geometry_ = own_geometry(device_, meshes_);
};

TEST_F(PluginUpdates, VerticesInPlace) {
  expect_as_new(1);
  const TestMesh other = triangle_soup(9, 100, 5);
  for (unsigned step = 0; step < 5; ++step) {
    std::copy(other.steps[step].begin(), other.steps[step].end(), meshes_[0].steps[step].begin());
  }
  expect_as_new(2);
}

TEST_F(PluginUpdates, MoreStepsFewerStepsStaticMoving) {
  expect_as_new(1);
  meshes_[0] = triangle_soup(3, 100, 17);
  set(0);
  expect_as_new(2);
  meshes_[0] = triangle_soup(4, 100, 1);
  set(0);
  expect_as_new(3);
  meshes_[1] = triangle_soup(5, 100, 2);
  set(1);
  expect_as_new(4);
}

TEST_F(PluginUpdates, Masks) {
  expect_as_new(1);
  meshes_[0].mask = 0;
  set(0);
  expect_as_new(2);
  meshes_[0].mask = 4;
  meshes_[1].mask = 0;
  set(0);
  set(1);
  expect_as_new(3);
}

TEST_F(PluginUpdates, MeshesAdded) {
  expect_as_new(1);
  meshes_.push_back(triangle_soup(6, 100, 3));
  std::vector<const void*> pointers;
  StbvhMeshArguments arguments = arguments_of(meshes_[2], pointers);
  arguments.geomID = 2;
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE);
  expect_as_new(2);
}

}  // namespace
}  // namespace stbvh::test
