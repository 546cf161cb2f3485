/// What stays with Embree, and that nothing else does for its sake.
#include <atomic>
#include <limits>
#include <stdexcept>

#include "plugin/preload/environment.h"
#include "plugin/preload/tracked_geometry.h"
#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

using preload::StaysNative;

TEST(PreloadNative, WhatIsAtRestStaysWithEmbree) {
  const Mesh still = flat_triangle(0, 1), moving = flat_triangle(1, 2);
  Twice twice;
  twice.add(still);
  twice.commit();
  EXPECT_FALSE(is_taken_over(twice.our_scene));
  twice.add(moving);
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
    const RTCGeometry geometry = embree.rtcGetGeometry(scene, 1);
    embree.rtcSetGeometryTimeRange(geometry, 0.5f, 0.5f);  // empty, which Embree takes
    EXPECT_EQ(embree.rtcGetDeviceError(scene == twice.our_scene ? twice.our_device : twice.native_device),
              RTC_ERROR_NONE);
    embree.rtcSetGeometryTimeRange(geometry, 0, 1);
    embree.rtcSetGeometryTimeStepCount(geometry, 1);  // at rest from now on
    embree.rtcCommitGeometry(geometry);
    embree.rtcDetachGeometry(scene, 0);
  });
  twice.commit();
  EXPECT_FALSE(is_taken_over(twice.our_scene));
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.5f), 1u);
  EXPECT_EQ(geom_id_hit(twice.native_scene, 0, 0, 0.5f), 1u);
}

using Spoil = std::function<void(RTCGeometry)>;

StaysNative reason_of(RTCGeometry geometry) {
  return preload::geometries().find(geometry)->why_native();
}

StaysNative reason_after(RTCDevice device, const Mesh& mesh, const Spoil& spoil) {
  const RTCGeometry geometry = new_mesh(ours(), device, mesh);
  ours().rtcCommitGeometry(geometry);
  spoil(geometry);
  const StaysNative reason = reason_of(geometry);
  ours().rtcReleaseGeometry(geometry);
  return reason;
}

TEST(PreloadNative, AMeshWithoutBuffersIsLeftToEmbree) {
  const RTCDevice device = ours().rtcNewDevice(nullptr);
  const RTCGeometry geometry = ours().rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  ours().rtcSetGeometryTimeStepCount(geometry, 2);
  ours().rtcCommitGeometry(geometry);
  EXPECT_EQ(reason_of(geometry), StaysNative::kBuffers);
  ours().rtcReleaseGeometry(geometry);
  ours().rtcReleaseDevice(device);
}

/// Without a scene: Embree fails assertions when it builds a mesh whose time range is empty.
TEST(PreloadNative, EachReasonIsSeen) {
  const Mesh mesh = flat_triangle(0, 3);
  const RTCDevice device = ours().rtcNewDevice(nullptr);
  const auto reason = [&](const Spoil& spoil) { return reason_after(device, mesh, spoil); };
  const auto with_range = [&](float begin, float end) {
    return reason([=](RTCGeometry geometry) {
      ours().rtcSetGeometryTimeRange(geometry, begin, end);
      ours().rtcCommitGeometry(geometry);
    });
  };
  const auto with_steps = [&](unsigned count) {
    return reason([=](RTCGeometry geometry) {
      ours().rtcSetGeometryTimeStepCount(geometry, count);
      ours().rtcCommitGeometry(geometry);
    });
  };
  const std::vector<float> vertices(3 * 4);
  const auto with_stride = [&](std::size_t stride) {
    return reason([&, stride](RTCGeometry geometry) {
      for (unsigned step = 0; step < 3; ++step) {
        ours().rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3,
                                          vertices.data(), 0, stride, 3);
      }
      ours().rtcCommitGeometry(geometry);
    });
  };
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(reason([](RTCGeometry) {}), StaysNative::kNone);
  EXPECT_EQ(reason([](RTCGeometry geometry) { ours().rtcSetGeometryMask(geometry, 3); }),
            StaysNative::kUncommitted);
  EXPECT_EQ(with_range(0, 0.5f), StaysNative::kNone);
  EXPECT_EQ(with_range(0.5f, 0.5f), StaysNative::kTimeRange);
  EXPECT_EQ(with_range(0, kInfinity), StaysNative::kTimeRange);
  EXPECT_EQ(with_range(-3e38f, 3e38f), StaysNative::kTimeRange);
  EXPECT_EQ(with_range(std::numeric_limits<float>::quiet_NaN(), 1), StaysNative::kTimeRange);
  EXPECT_EQ(with_range(0, 1e-39f), StaysNative::kTimeRange);
  EXPECT_EQ(with_range(-1e-39f, 1e-39f), StaysNative::kTimeRange);
  EXPECT_EQ(with_range(0, std::numeric_limits<float>::min()), StaysNative::kNone);
  EXPECT_EQ(with_stride(16), StaysNative::kNone);
  EXPECT_EQ(with_stride(0), StaysNative::kBuffers);
  EXPECT_EQ(with_stride(8), StaysNative::kBuffers);
  EXPECT_EQ(with_steps(2), StaysNative::kNone);
  EXPECT_EQ(with_steps(1), preload::environment().all_triangles ? StaysNative::kNone : StaysNative::kOneStep);
  EXPECT_EQ(ours().rtcGetDeviceError(device), RTC_ERROR_NONE);
  ours().rtcReleaseDevice(device);
}

TEST(PreloadNative, AMeshThatCannotBeTakenOverKeepsNoOtherFromIt) {
  const Mesh good = triangle_soup(1, 100, 3), other = flat_triangle(5, 3);
  Twice twice;
  twice.add(good);
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCGeometry geometry = new_mesh(embree, device, other);
    embree.rtcSetGeometryTimeStepCount(geometry, 4);  // of which one has no vertices
    attach(embree, scene, geometry);
    embree.rtcCommitScene(scene);
  });
  const RTCError error = native().rtcGetDeviceError(twice.native_device);
  EXPECT_NE(error, RTC_ERROR_NONE);
  EXPECT_EQ(ours().rtcGetDeviceError(twice.our_device), error);
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  twice.both([](const Embree& embree, RTCDevice, RTCScene scene) { embree.rtcDetachGeometry(scene, 1); });
  twice.commit();
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(4, 500));
}

/// What Embree takes and our build does not: the others of the scene are hit as before. Not in the native
/// scene: Embree never hits such a mesh, and with some others beside it fails an assertion.
TEST(PreloadNative, AMeshWhoseTimeRangeIsNextToEmptyKeepsNoOtherFromIt) {
  const Mesh good = triangle_soup(1, 100, 3);
  Mesh narrow = flat_triangle(5, 3);
  narrow.end_time = 1e-39f;
  Twice twice;
  twice.add(good);
  attach(ours(), twice.our_scene, new_mesh(ours(), twice.our_device, narrow));
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  EXPECT_EQ(reason_of(ours().rtcGetGeometry(twice.our_scene, 1)), StaysNative::kTimeRange);
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(7, 500));
}

/// A memory monitor that throws once, when it is armed, what the encoder throws of a structure above 32 GiB:
/// a build passes on what its callbacks throw, and nothing so large needs to be built.
struct TooLargeOnce {
  static bool on_memory(void* self, ssize_t bytes, bool) {
    TooLargeOnce& state = *static_cast<TooLargeOnce*>(self);
    state.in_use += bytes;
    if (bytes > 0 && state.is_armed.exchange(false)) {
      state.in_use -= bytes;
      throw std::length_error("structure larger than 32 GiB");
    }
    return true;
  }

  std::atomic<bool> is_armed{false};
  std::atomic<ssize_t> in_use{0};
};

TEST(PreloadNative, AStructureThatWouldBeTooLargeIsLeftToEmbree) {
  const Mesh large = triangle_soup(1, 500, 3), small = triangle_soup(2, 50, 2);
  TooLargeOnce monitor;
  {
    Twice twice;
    ours().rtcSetDeviceMemoryMonitorFunction(twice.our_device, TooLargeOnce::on_memory, &monitor);
    twice.add(large);
    const RTCGeometry handle = ours().rtcGetGeometry(twice.our_scene, 0);
    monitor.is_armed = true;
    twice.commit();
    EXPECT_FALSE(monitor.is_armed);
    EXPECT_FALSE(is_taken_over(twice.our_scene));
    EXPECT_EQ(reason_of(handle), StaysNative::kTooLarge);
    expect_same_hits(twice.our_scene, twice.native_scene, random_rays(5, 1000));
    // The next commit does not try again; other meshes are taken over.
    twice.add(small);
    twice.commit();
    EXPECT_TRUE(is_taken_over(twice.our_scene));
    EXPECT_EQ(reason_of(handle), StaysNative::kTooLarge);
    expect_same_hits(twice.our_scene, twice.native_scene, random_rays(6, 1000));
  }
  EXPECT_EQ(monitor.in_use, 0);
}

}  // namespace
}  // namespace stbvh::preload_test
