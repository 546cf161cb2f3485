// Memory that runs out in each allocation of a small scene: an error, nothing wrong, nothing lost.
#include <atomic>

#include "tests/failing_allocations.h"
#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

using Which = FailingAllocations::Which;

/// The device's memory monitor, which may refuse one request.
struct Monitor {
  static bool on_memory(void* self, ssize_t bytes, bool) {
    auto& monitor = *static_cast<Monitor*>(self);
    if (bytes > 0 && monitor.requests++ == monitor.refused) return false;
    monitor.bytes += bytes;
    return true;
  }

  std::atomic<ssize_t> bytes{0};
  std::atomic<long> requests{0};
  std::atomic<long> refused{-1};
};

class PluginOutOfMemory : public testing::Test {
 protected:
  PluginOutOfMemory() { rtcSetDeviceMemoryMonitorFunction(device_.get(), Monitor::on_memory, &monitor_); }

  void expect_error(RTCError error) const {
    if (error == RTC_ERROR_NONE) return;
    EXPECT_EQ(error, RTC_ERROR_OUT_OF_MEMORY);
    EXPECT_STREQ(stbvhGetErrorMessage(geometry_.get()),
                 "out of memory, or the device's memory monitor refused");
  }

  /// What is still missing of: a geometry with all meshes, committed. Whether it is all there.
  bool build() {
    if (geometry_ == nullptr) geometry_.reset(stbvhNewGeometry(device_.get()));
    if (geometry_ == nullptr) {
      EXPECT_STREQ(stbvhGetErrorMessage(nullptr), "out of memory for another geometry");
      return false;
    }
    RTCError error = RTC_ERROR_NONE;
    while (error == RTC_ERROR_NONE && stbvhGetMeshCount(geometry_.get()) < arguments_.size()) {
      error = stbvhAddMesh(geometry_.get(), &arguments_[stbvhGetMeshCount(geometry_.get())], nullptr);
    }
    if (error == RTC_ERROR_NONE) error = stbvhCommitGeometry(geometry_.get());
    expect_error(error);
    return error == RTC_ERROR_NONE;
  }

  void expect_hits() {
    const Scene scene = new_scene(device_);
    rtcAttachGeometryByID(scene.get(), stbvhGetGeometry(geometry_.get()), 0);
    rtcCommitScene(scene.get());
    ASSERT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_NONE);
    const RTCRayHit hit = intersect(scene.get(), ray_down(.1f, .1f, .5f));
    EXPECT_EQ(hit.hit.geomID, 1u);
    EXPECT_EQ(hit.ray.tfar, 8.0f);
  }

  /// After a build that may have failed: it has succeeded wholly, or it does when it is tried again.
  void expect_recovery(bool built) {
    rtcGetDeviceError(device_.get());  // of Embree's own
    if (built) expect_hits();
    ASSERT_TRUE(build());
    expect_hits();
    geometry_.reset();
    EXPECT_EQ(monitor_.bytes, 0);
  }

  Monitor monitor_;
  Device device_ = new_device();
  std::vector<TestMesh> meshes_{flat_triangle(0, 1), flat_triangle(2, 3), triangle_soup(1, 20, 2)};
  std::vector<const void*> pointers_[3];
  std::vector<StbvhMeshArguments> arguments_ = [this] {
    std::vector<StbvhMeshArguments> all;
    for (unsigned i = 0; i < 3; ++i) {
      all.push_back(arguments_of(meshes_[i], pointers_[i]));
      all.back().geomID = i;
    }
    return all;
  }();
  OwnGeometry geometry_;
};

TEST_F(PluginOutOfMemory, InEachAllocation) {
  for (const Which which : {Which::kOne, Which::kAllFrom}) {
    bool have_failed = true;
    for (long number = 0; have_failed; ++number) {
      SCOPED_TRACE(testing::Message()
                   << "allocation " << number << (which == Which::kOne ? "" : " and all that follow"));
      bool built = false;
      {
        const FailingAllocations failing(number, which);
        built = build();
        have_failed = failing.have_failed();
      }
      // Where there is memory again, the device can be told.
      if (which == Which::kOne && !built) {
        EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_OUT_OF_MEMORY);
      }
      ASSERT_NO_FATAL_FAILURE(expect_recovery(built));
      ASSERT_TRUE(built || have_failed);
    }
  }
}

/// Of a build that has tasks, the first allocations and some of the others.
TEST_F(PluginOutOfMemory, InABuildWithTasks) {
  meshes_[2] = triangle_soup(1, 4000, 5);
  arguments_[2] = arguments_of(meshes_[2], pointers_[2]);
  bool have_failed = true;
  for (long number = 0; have_failed; number += 1 + number / 16) {
    SCOPED_TRACE(testing::Message() << "allocation " << number);
    bool built = false;
    {
      const FailingAllocations failing(number, Which::kAllFrom);
      built = build();
      have_failed = failing.have_failed();
    }
    ASSERT_NO_FATAL_FAILURE(expect_recovery(built));
  }
}

TEST_F(PluginOutOfMemory, AsTheMemoryMonitorSays) {
  bool have_refused = true;
  for (long number = 0; have_refused; ++number) {
    SCOPED_TRACE(testing::Message() << "request " << number);
    monitor_.requests = 0;
    monitor_.refused = number;
    const bool built = build();
    have_refused = monitor_.requests > number;
    monitor_.refused = -1;
    EXPECT_NE(built, have_refused);
    ASSERT_NO_FATAL_FAILURE(expect_recovery(built));
  }
}

}  // namespace
}  // namespace stbvh::test
