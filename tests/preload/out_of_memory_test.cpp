// Memory that runs out in each allocation of a small scene, ours and Embree's: where no error is reported all
// rays hit what they should, and nothing is lost.
#include <atomic>
#include <optional>

#include "tests/failing_allocations.h"
#include "tests/preload/two_embrees.h"

#ifdef __SANITIZE_ADDRESS__
/// Embree 3.13.5 alone loses geometries where memory ends within one of its functions.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libembree";
}
#endif

namespace stbvh::preload_test {
namespace {

using test::FailingAllocations;
using Which = FailingAllocations::Which;

struct Monitor {
  static bool on_memory(void* self, ssize_t bytes, bool) {
    static_cast<Monitor*>(self)->bytes += bytes;
    return true;
  }
  std::atomic<ssize_t> bytes{0};
};

/// As an application makes it, that looks at errors at the end only.
class SmallScene {
 public:
  SmallScene(RTCDevice device, const std::vector<Mesh>& meshes) : scene_(ours().rtcNewScene(device)) {
    if (scene_ == nullptr) return;
    for (const Mesh& mesh : meshes) {
      const RTCGeometry geometry = new_mesh(ours(), device, mesh);
      if (geometry != nullptr) attach(ours(), scene_, geometry);
    }
    // Embree 3.13.5 and 4.3.3 alone: where FastAllocator cannot note a thread's allocator, that keeps a
    // pointer to the FastAllocator or is freed itself, and the thread's next build writes there.
    const test::SparedLibrary embree(reinterpret_cast<const void*>(native().rtcCommitScene));
    ours().rtcCommitScene(scene_);
  }
  ~SmallScene() {
    if (scene_ != nullptr) ours().rtcReleaseScene(scene_);
  }
  SmallScene(const SmallScene&) = delete;
  SmallScene& operator=(const SmallScene&) = delete;

  void expect_hits() const {
    ASSERT_NE(scene_, nullptr);
    EXPECT_TRUE(is_taken_over(scene_));
    EXPECT_EQ(geom_id_hit(scene_, 0, 0, 0.5f), 0u);
    EXPECT_EQ(geom_id_hit(scene_, 2, 2, 0.5f), RTC_INVALID_GEOMETRY_ID);
  }

 private:
  RTCScene scene_;
};

TEST(PreloadOutOfMemory, InEachAllocation) {
  const std::vector<Mesh> meshes{flat_triangle(0, 2), flat_triangle(1, 3)};
  for (const Which which : {Which::kOne, Which::kAllFrom}) {
    bool have_failed = true;
    for (long number = 0; have_failed; ++number) {
      SCOPED_TRACE(testing::Message()
                   << "allocation " << number << (which == Which::kOne ? "" : " and all that follow"));
      Monitor monitor;
      const RTCDevice device = ours().rtcNewDevice(nullptr);
      ours().rtcSetDeviceMemoryMonitorFunction(device, Monitor::on_memory, &monitor);
      // Embree takes memory for the first error of a thread, and its functions throw if there is none.
      EXPECT_EQ(ours().rtcGetDeviceError(device), RTC_ERROR_NONE);
      {
        std::optional<SmallScene> scene;
        {
          const FailingAllocations failing(number, which);
          scene.emplace(device, meshes);
          have_failed = failing.have_failed();
        }
        if (ours().rtcGetDeviceError(device) == RTC_ERROR_NONE) scene->expect_hits();
        while (ours().rtcGetDeviceError(device) != RTC_ERROR_NONE) {
        }
      }
      SmallScene(device, meshes).expect_hits();
      EXPECT_EQ(ours().rtcGetDeviceError(device), RTC_ERROR_NONE);
      ours().rtcReleaseDevice(device);
      EXPECT_EQ(monitor.bytes, 0);
      ASSERT_FALSE(HasFailure());
    }
  }
}

}  // namespace
}  // namespace stbvh::preload_test
