// The IDs that hits report: given to a mesh, or the one under which the geometry is attached.
#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

class PluginGeomIDs : public testing::Test {
 protected:
  /// Adds triangle `i` at height i, which is hit first if it is the last; its geomID is `id`.
  void add(unsigned id) {
    meshes_.push_back(flat_triangle(static_cast<float>(meshes_.size()), 2));
    StbvhMeshArguments arguments = arguments_of(meshes_.back(), pointers_);
    arguments.geomID = id;
    ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE);
  }

  void set_id(unsigned index, unsigned id) {
    StbvhMeshArguments arguments;
    stbvhInitMeshArguments(&arguments);
    ASSERT_EQ(stbvhGetMesh(geometry_.get(), index, &arguments), RTC_ERROR_NONE);
    arguments.geomID = id;
    ASSERT_EQ(stbvhSetMesh(geometry_.get(), index, &arguments), RTC_ERROR_NONE);
  }

  unsigned id_from_above() const {
    const Scene scene = new_scene(device_);
    rtcAttachGeometryByID(scene.get(), stbvhGetGeometry(geometry_.get()), 7);
    rtcCommitScene(scene.get());
    return intersect(scene.get(), ray_down(.1f, .1f, .5f)).hit.geomID;
  }

  unsigned id_from_above_directly() const {
    return intersect_directly(geometry_.get(), ray_down(.1f, .1f, .5f)).hit.geomID;
  }

  static constexpr unsigned kDefault = RTC_INVALID_GEOMETRY_ID;
  Device device_ = new_device();
  OwnGeometry geometry_{stbvhNewGeometry(device_.get())};
  std::vector<TestMesh> meshes_;
  std::vector<const void*> pointers_;
};

TEST_F(PluginGeomIDs, OneMeshMayKeepTheDefault) {
  add(30), add(31), add(kDefault);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE) << stbvhGetErrorMessage(geometry_.get());
  EXPECT_EQ(id_from_above(), 7u);
  EXPECT_EQ(id_from_above_directly(), 2u);  // not attached: its index
  set_id(1, kDefault), set_id(2, 32);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  EXPECT_EQ(id_from_above(), 32u);
  EXPECT_EQ(id_from_above_directly(), 32u);
}

TEST_F(PluginGeomIDs, TwoMeshesAtTheDefaultAreRefusedByTheCommit) {
  add(kDefault), add(31);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  EXPECT_EQ(id_from_above(), 31u);
  add(kDefault), add(kDefault);
  EXPECT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_INVALID_OPERATION);
  EXPECT_STREQ(stbvhGetErrorMessage(geometry_.get()),
               "meshes 0 and 2 both have the default geomID, so that their hits could not be told apart: set "
               "geomID of all meshes but one");
  EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_INVALID_OPERATION);
  // As after each failed commit.
  EXPECT_EQ(id_from_above(), RTC_INVALID_GEOMETRY_ID);
  EXPECT_EQ(id_from_above_directly(), RTC_INVALID_GEOMETRY_ID);
  EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_NONE);
  set_id(2, 32), set_id(3, 33);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  EXPECT_EQ(id_from_above(), 33u);
}

}  // namespace
}  // namespace stbvh::test
