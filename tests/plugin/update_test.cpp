// Changes after the first commit.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

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

StbvhStatistics statistics_of(const OwnGeometry& geometry) {
  StbvhStatistics statistics;
  stbvhInitStatistics(&statistics);
  EXPECT_EQ(stbvhGetStatistics(geometry.get(), &statistics), RTC_ERROR_NONE);
  return statistics;
}

StbvhStatistics commit(const OwnGeometry& geometry) {
  EXPECT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  return statistics_of(geometry);
}

TEST_F(PluginUpdates, DoTheWorkOfTheChangeOnly) {
  meshes_.clear();
  for (std::uint32_t i = 0; i < 10; ++i) meshes_.push_back(triangle_soup(20 + i, 50, i % 2 == 0 ? 5 : 1));
  geometry_ = own_geometry(device_, meshes_);
  const StbvhStatistics built = statistics_of(geometry_);
  EXPECT_EQ(built.isUpdate, 0u);
  EXPECT_EQ(built.meshesBuilt, 10u);
  EXPECT_EQ(built.expectedCost, 1.0);
  EXPECT_GT(built.commitSeconds, 0.0);

  const StbvhStatistics nothing = commit(geometry_);
  EXPECT_EQ(nothing.isUpdate, 1u);
  EXPECT_EQ(nothing.meshesBuilt + nothing.meshesRefitted + nothing.meshesRemoved, 0u);

  for (auto& step : meshes_[4].steps) {
    for (Position& p : step) p.x += 0.01f;
  }
  const StbvhStatistics refitted = commit(geometry_);
  EXPECT_EQ(refitted.isUpdate, 1u);
  EXPECT_EQ(refitted.meshesRefitted, 1u);
  EXPECT_EQ(refitted.meshesBuilt, 0u);
  EXPECT_GT(refitted.leavesRefitted, 0u);
  EXPECT_EQ(refitted.structureBytes, built.structureBytes);
  EXPECT_EQ(refitted.triangles, built.triangles);

  meshes_[3] = triangle_soup(99, 30, 1);
  set(3);
  const StbvhStatistics replaced = commit(geometry_);
  EXPECT_EQ(replaced.isUpdate, 1u);
  EXPECT_EQ(replaced.meshesRefitted, 0u);
  EXPECT_EQ(replaced.meshesBuilt, 1u);
  EXPECT_EQ(replaced.triangles, built.triangles - 20);

  StbvhMeshArguments without_triangles;
  stbvhInitMeshArguments(&without_triangles);
  ASSERT_EQ(stbvhGetMesh(geometry_.get(), 3, &without_triangles), RTC_ERROR_NONE);
  without_triangles.triangleCount = 0;
  ASSERT_EQ(stbvhSetMesh(geometry_.get(), 3, &without_triangles), RTC_ERROR_NONE);
  const StbvhStatistics removed = commit(geometry_);
  EXPECT_EQ(removed.isUpdate, 1u);
  EXPECT_EQ(removed.meshesRemoved, 1u);
  EXPECT_EQ(removed.meshesBuilt, 0u);
  EXPECT_EQ(removed.triangles, built.triangles - 50);

  ASSERT_EQ(stbvhSetGeometryTolerance(geometry_.get(), STBVH_KEEP_ALL_STEPS), RTC_ERROR_NONE);
  EXPECT_EQ(commit(geometry_).isUpdate, 0u);
}

/// The device's memory monitor and the commit's progress function, which may stop a commit.
struct Watch {
  static bool on_memory(void* self, ssize_t bytes, bool) {
    auto& watch = *static_cast<Watch*>(self);
    if (bytes > 0 && watch.until_refused >= 0 && watch.until_refused-- == 0) return false;
    watch.bytes += bytes;
    return true;
  }
  static bool on_progress(void* self, double fraction) {
    auto& watch = *static_cast<Watch*>(self);
    watch.in_order &= fraction >= watch.last && fraction <= 1;
    watch.last = fraction;
    return watch.until_cancelled < 0 || watch.until_cancelled-- > 0;
  }

  std::atomic<ssize_t> bytes{0};
  std::atomic<long> until_refused{-1}, until_cancelled{-1};
  double last = 0;
  bool in_order = true;
};

/// Sequences of edits, some commits of which are cancelled or refused memory: answers are those of a geometry
/// made of the same meshes, bit for bit.
TEST(PluginEdits, RandomSequencesAnswerAsNew) {
  Watch watch;
  std::size_t updates = 0, failures = 0;
  const char* const asked = std::getenv("STBVH_EDIT_SEQUENCES");  // a long run
  const auto seeds = static_cast<std::uint32_t>(asked != nullptr ? std::atoi(asked) : 25);
  {
    const Device device = new_device();
    rtcSetDeviceErrorFunction(
        device.get(), [](void*, RTCError, const char*) {}, nullptr);
    rtcSetDeviceMemoryMonitorFunction(device.get(), Watch::on_memory, &watch);
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
      Random random(seed);
      const auto up_to = [&](std::size_t n) {
        return std::min(static_cast<std::size_t>(random.unit() * static_cast<float>(n)), n - 1);
      };
      std::vector<TestMesh> meshes;
      for (std::uint32_t i = 0; i < 8; ++i)
        meshes.push_back(triangle_soup(100 * seed + i, 40, i % 3 * 2 + 1));
      OwnGeometry geometry = own_geometry(device, meshes);
      ASSERT_EQ(stbvhSetGeometryProgressFunction(geometry.get(), Watch::on_progress, &watch), RTC_ERROR_NONE);
      const Scene scene = new_scene(device);
      rtcAttachGeometryByID(scene.get(), stbvhGetGeometry(geometry.get()), 1000);
      for (int edit = 0; edit < 12; ++edit) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", edit " << edit);
        const auto number = static_cast<unsigned>(edit);
        const std::size_t i = up_to(meshes.size());
        TestMesh& mesh = meshes[i];
        const std::size_t kind = up_to(6);
        if (kind <= 1) {
          const float by = kind == 0 ? 0.05f : 0.6f;
          for (auto& step : mesh.steps) {
            for (Position& p : step) p.y += by * (2 * random.unit() - 1);
          }
        } else if (kind == 5) {
          meshes.push_back(triangle_soup(10000 + 100 * seed + number, 30, 3));
          std::vector<const void*> pointers;
          StbvhMeshArguments arguments = arguments_of(meshes.back(), pointers);
          arguments.geomID = static_cast<unsigned>(meshes.size() - 1);
          ASSERT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
        } else {
          if (kind == 2) mesh.mask = mesh.mask == 0 ? 0xFFFFFFFFu : 0u;
          if (kind == 3) mesh = triangle_soup(50000 + 100 * seed + number, 20 + 5 * number, 1 + number % 5);
          std::vector<const void*> pointers;
          StbvhMeshArguments arguments = arguments_of(mesh, pointers);
          arguments.geomID = static_cast<unsigned>(i);
          if (kind == 4) arguments.triangleCount = 0;
          if (kind == 4) mesh.indices.clear();
          ASSERT_EQ(stbvhSetMesh(geometry.get(), static_cast<unsigned>(i), &arguments), RTC_ERROR_NONE);
        }
        if (edit % 4 == 1) watch.until_refused = static_cast<long>(up_to(3));
        if (edit % 4 == 3) watch.until_cancelled = static_cast<long>(up_to(4));
        watch.last = 0;
        const RTCError error = stbvhCommitGeometry(geometry.get());
        watch.until_refused = watch.until_cancelled = -1;
        EXPECT_TRUE(watch.in_order);
        if (error != RTC_ERROR_NONE) {
          ++failures;
          EXPECT_TRUE(error == RTC_ERROR_OUT_OF_MEMORY || error == RTC_ERROR_CANCELLED);
          EXPECT_EQ(statistics_of(geometry).triangles, 0u);
          watch.last = 0;
          ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
        }
        updates += statistics_of(geometry).isUpdate;
        rtcCommitScene(scene.get());
        const OwnGeometry anew = own_geometry(device, meshes);
        const Scene scene_anew = new_scene(device);
        rtcAttachGeometryByID(scene_anew.get(), stbvhGetGeometry(anew.get()), 1000);
        rtcCommitScene(scene_anew.get());
        EXPECT_EQ(statistics_of(geometry).triangles, statistics_of(anew).triangles);
        for (int k = 0; k < 200; ++k) {
          const RTCRayHit ray = random_ray(random);
          const RTCRayHit a = intersect(scene.get(), ray), b = intersect(scene_anew.get(), ray);
          ASSERT_EQ(a.ray.tfar, b.ray.tfar);
          ASSERT_EQ(a.hit.geomID, b.hit.geomID);
          ASSERT_EQ(a.hit.primID, b.hit.primID);
          ASSERT_EQ(a.hit.u, b.hit.u);
          ASSERT_EQ(a.hit.Ng_x, b.hit.Ng_x);
        }
      }
    }
  }
  EXPECT_EQ(watch.bytes, 0);
  EXPECT_GT(updates, 6u * seeds);
  EXPECT_GT(failures, seeds * 4 / 5);
}

TEST_F(PluginUpdates, SavedTreesAreThereAgain) {
  const std::string file = testing::TempDir() + "saved_" + std::to_string(getpid()) + ".stbvh";
  ASSERT_EQ(stbvhSaveGeometry(geometry_.get(), file.c_str()), RTC_ERROR_NONE);
  const StbvhStatistics built = statistics_of(geometry_);

  const auto new_geometry = [&] {
    OwnGeometry geometry(stbvhNewGeometry(device_.get()));
    for (unsigned i = 0; i < meshes_.size(); ++i) {
      std::vector<const void*> pointers;
      StbvhMeshArguments arguments = arguments_of(meshes_[i], pointers);
      arguments.geomID = i;
      EXPECT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
    }
    return geometry;
  };
  const OwnGeometry again = new_geometry();
  EXPECT_EQ(stbvhSaveGeometry(again.get(), file.c_str()), RTC_ERROR_INVALID_OPERATION);  // not committed
  ASSERT_EQ(stbvhCommitSavedGeometry(again.get(), file.c_str()), RTC_ERROR_NONE);
  EXPECT_EQ(statistics_of(again).triangles, built.triangles);
  EXPECT_EQ(statistics_of(again).structureBytes, built.structureBytes);
  const Scene scene = new_scene(device_);
  rtcAttachGeometryByID(scene.get(), stbvhGetGeometry(again.get()), 1000);
  rtcCommitScene(scene.get());
  const Scene native = new_scene(device_);
  for (unsigned i = 0; i < meshes_.size(); ++i)
    rtcAttachGeometryByID(native.get(), native_geometry(device_, meshes_[i]).get(), i);
  rtcCommitScene(native.get());
  expect_same_hits(native.get(), scene.get(), 1500, 3);

  // It is changed as any other.
  for (auto& step : meshes_[0].steps) {
    for (Position& p : step) p.z += 0.05f;
  }
  ASSERT_EQ(stbvhCommitGeometry(again.get()), RTC_ERROR_NONE);
  EXPECT_EQ(statistics_of(again).isUpdate, 1u);
  rtcCommitScene(scene.get());
  const Scene moved = new_scene(device_);
  for (unsigned i = 0; i < meshes_.size(); ++i)
    rtcAttachGeometryByID(moved.get(), native_geometry(device_, meshes_[i]).get(), i);
  rtcCommitScene(moved.get());
  expect_same_hits(moved.get(), scene.get(), 1500, 4);

  const auto refused = [&](const OwnGeometry& geometry, const std::string& name, const std::string& problem) {
    EXPECT_EQ(stbvhCommitSavedGeometry(geometry.get(), name.c_str()), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(stbvhGetErrorMessage(geometry.get())).find(problem), std::string::npos)
        << stbvhGetErrorMessage(geometry.get());
    EXPECT_EQ(statistics_of(geometry).triangles, 0u);
  };
  refused(again, file, "is of meshes that differ from these");
  refused(again, file + "x", "cannot be read");
  const OwnGeometry other = new_geometry();
  ASSERT_EQ(stbvhSetGeometryTolerance(other.get(), 1.0f), RTC_ERROR_NONE);
  refused(other, file, "other settings");
  EXPECT_EQ(stbvhSaveGeometry(geometry_.get(), file.c_str()),
            RTC_ERROR_INVALID_OPERATION);  // a mesh has changed
  EXPECT_EQ(stbvhSaveGeometry(geometry_.get(), nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhCommitSavedGeometry(nullptr, file.c_str()), RTC_ERROR_INVALID_ARGUMENT);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  EXPECT_EQ(stbvhSaveGeometry(geometry_.get(), "/no/such/folder/file.stbvh"), RTC_ERROR_UNKNOWN);
  std::remove(file.c_str());
}

}  // namespace
}  // namespace stbvh::test
