// Failing functions set the device's error and call its error function, as Embree's own do.
#include "plugin/device_error.h"

#include <string>
#include <thread>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

class PluginDeviceErrors : public testing::Test {
 protected:
  static void on_error(void* self, RTCError code, const char*) {
    auto& test = *static_cast<PluginDeviceErrors*>(self);
    test.codes_.push_back(code);
    test.reason_ = stbvhGetErrorMessage(test.geometry_.get());
  }
  static bool on_memory(void* self, ssize_t bytes, bool) {
    static_cast<PluginDeviceErrors*>(self)->bytes_ += bytes;
    return true;
  }

  PluginDeviceErrors() {
    rtcGetDeviceError(nullptr);  // of other tests in this process
    rtcSetDeviceErrorFunction(device_.get(), on_error, this);
    rtcSetDeviceMemoryMonitorFunction(device_.get(), on_memory, this);
  }
  ~PluginDeviceErrors() override {
    geometry_.reset();
    EXPECT_EQ(bytes_, 0);
  }

  /// The device was told of one error, on this thread.
  void expect_told(RTCError code) {
    EXPECT_EQ(codes_, std::vector{code});
    codes_.clear();
    EXPECT_EQ(rtcGetDeviceError(device_.get()), code);
    EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_NONE);
    EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
  }

  ssize_t bytes_ = 0;
  std::vector<RTCError> codes_;
  std::string reason_;
  Device device_ = new_device();
  OwnGeometry geometry_{stbvhNewGeometry(device_.get())};
};

TEST_F(PluginDeviceErrors, AreOfEachCode) {
  for (const RTCError code : {RTC_ERROR_UNKNOWN, RTC_ERROR_INVALID_ARGUMENT, RTC_ERROR_INVALID_OPERATION,
                              RTC_ERROR_OUT_OF_MEMORY, RTC_ERROR_CANCELLED}) {
    for (int i = 0; i < 3; ++i) {
      SCOPED_TRACE(code);
      plugin::set_device_error(device_.get(), code);
      expect_told(code);
    }
  }
}

TEST_F(PluginDeviceErrors, AreThoseThatFunctionsReturn) {
  StbvhMeshArguments mesh;
  stbvhInitMeshArguments(&mesh);
  StbvhStatistics statistics{};
  const auto expect_refused = [this](RTCError code) {
    EXPECT_EQ(code, RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(reason_, stbvhGetErrorMessage(geometry_.get()));  // known to the error function
    EXPECT_NE(reason_, "");
    expect_told(RTC_ERROR_INVALID_ARGUMENT);
  };
  expect_refused(stbvhAddMesh(geometry_.get(), nullptr, nullptr));
  expect_refused(stbvhSetMesh(geometry_.get(), 0, &mesh));
  expect_refused(stbvhGetMesh(geometry_.get(), 0, &mesh));
  expect_refused(stbvhSetGeometryPrecision(geometry_.get(), static_cast<StbvhPrecision>(2)));
  expect_refused(stbvhSetGeometryTolerance(geometry_.get(), -2));
  expect_refused(stbvhGetStatistics(geometry_.get(), &statistics));
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &mesh, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &mesh, nullptr), RTC_ERROR_NONE);
  EXPECT_EQ(codes_, std::vector<RTCError>());
  EXPECT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_INVALID_OPERATION);
  expect_told(RTC_ERROR_INVALID_OPERATION);
}

TEST_F(PluginDeviceErrors, OfNullAreTheThreads) {
  const auto expect_refused = [this](const char* reason) {
    EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
    EXPECT_STREQ(stbvhGetErrorMessage(nullptr), reason);
    EXPECT_STREQ(stbvhGetErrorMessage(geometry_.get()), "");
    EXPECT_EQ(codes_, std::vector<RTCError>());
  };
  EXPECT_EQ(stbvhNewGeometry(nullptr), nullptr);
  expect_refused("device is null");
  EXPECT_EQ(stbvhCommitGeometry(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  expect_refused("geometry is null");
  RTCRayHit ray = ray_down(.1f, .1f, .5f);
  intersect_one(StbvhGeometry{}, ray);
  expect_refused("geometry is null");
  occluded_one(StbvhGeometry{}, ray.ray);
  expect_refused("geometry is null");
  std::thread([] { EXPECT_STREQ(stbvhGetErrorMessage(nullptr), ""); }).join();
}

}  // namespace
}  // namespace stbvh::test
