// Memory and progress: every byte is reported and given back, also by builds that are cancelled.
#include <atomic>
#include <limits>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

struct Monitor {
  std::atomic<ssize_t> bytes{0};
  std::atomic<ssize_t> peak{0};
  std::atomic<long> allocations{0};
  std::atomic<bool> refused{false};
  long refuse_from = -1;  ///< number of the first allocation that is refused; < 0: none
};

bool monitor_memory(void* ptr, ssize_t bytes, bool) {
  auto& monitor = *static_cast<Monitor*>(ptr);
  if (bytes > 0 && monitor.refuse_from >= 0 && monitor.allocations >= monitor.refuse_from) {
    monitor.refused = true;
    return false;
  }
  if (bytes > 0) ++monitor.allocations;
  const ssize_t now = monitor.bytes += bytes;
  ssize_t peak = monitor.peak;
  while (now > peak && !monitor.peak.compare_exchange_weak(peak, now)) {
  }
  return true;
}

void ignore_error(void*, RTCError, const char*) {}

class PluginMemory : public testing::Test {
 protected:
  void SetUp() override { rtcSetDeviceMemoryMonitorFunction(device_.get(), monitor_memory, &monitor_); }

  void add_meshes(const OwnGeometry& geometry) const {
    std::vector<const void*> pointers;
    for (const TestMesh& mesh : meshes_) {
      StbvhMeshArguments arguments = arguments_of(mesh, pointers);
      arguments.geomID = stbvhGetMeshCount(geometry.get());
      ASSERT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
    }
  }

  /// The next commit builds anew, though nothing has changed.
  static void require_build(const OwnGeometry& geometry) {
    static float tolerance = 0.0f;
    tolerance += 1e-30f;
    ASSERT_EQ(stbvhSetGeometryTolerance(geometry.get(), tolerance), RTC_ERROR_NONE);
  }

  std::vector<TestMesh> meshes_{triangle_soup(1, 2000, 9), triangle_soup(2, 1500, 1),
                                triangle_soup(3, 1500, 4)};
  Monitor monitor_;
  Device device_ = new_device();
};

TEST_F(PluginMemory, IsLimited) {
  OwnGeometry geometry(stbvhNewGeometry(device_.get()));
  add_meshes(geometry);
  const auto commit = [&](std::size_t structure_bytes, std::size_t peak_bytes) {
    EXPECT_EQ(stbvhSetGeometryMaxBytes(geometry.get(), structure_bytes, peak_bytes), RTC_ERROR_NONE);
    const RTCError error = stbvhCommitGeometry(geometry.get());
    StbvhStatistics statistics;
    stbvhInitStatistics(&statistics);
    EXPECT_EQ(stbvhGetStatistics(geometry.get(), &statistics), RTC_ERROR_NONE);
    EXPECT_EQ(statistics.structureBytes > 0, error == RTC_ERROR_NONE);
    if (error != RTC_ERROR_NONE) statistics.structureBytes = 0;
    return statistics;
  };
  const StbvhStatistics all = commit(STBVH_NO_LIMIT, STBVH_NO_LIMIT);
  EXPECT_EQ(all.wantedBytes, all.structureBytes);
  EXPECT_GT(all.leaves, 0u);
  EXPECT_EQ(all.indexedLeaves, 0u);
  for (const std::size_t percent : {90u, 70u, 50u}) {
    const std::size_t limit = all.structureBytes * percent / 100;
    const StbvhStatistics limited = commit(limit, STBVH_NO_LIMIT);
    EXPECT_LE(limited.structureBytes, limit);
    EXPECT_GT(limited.structureBytes, limit * 8 / 10);
    EXPECT_GT(limited.indexedLeaves, 0u);
    EXPECT_GT(limited.wantedBytes, limited.structureBytes);
    EXPECT_EQ(limited.triangles, all.triangles);
  }
  const std::size_t peak = all.peakBytes * 9 / 10;
  const StbvhStatistics low = commit(STBVH_NO_LIMIT, peak);
  EXPECT_GT(low.structureBytes, 0u);
  EXPECT_LE(low.peakBytes, peak);
  for (const auto& [structure_bytes, peak_bytes] :
       {std::pair<std::size_t, std::size_t>{1000, STBVH_NO_LIMIT}, {STBVH_NO_LIMIT, 1000}, {0, 0}}) {
    EXPECT_EQ(commit(structure_bytes, peak_bytes).structureBytes, 0u);
    EXPECT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_OUT_OF_MEMORY);
    EXPECT_STRNE(stbvhGetErrorMessage(geometry.get()), "");
  }
  EXPECT_EQ(commit(STBVH_NO_LIMIT, STBVH_NO_LIMIT).structureBytes, all.structureBytes);
}

TEST_F(PluginMemory, IsReportedAndGivenBack) {
  const ssize_t before = monitor_.bytes;
  {
    OwnGeometry geometry(stbvhNewGeometry(device_.get()));
    add_meshes(geometry);
    ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
    StbvhStatistics statistics;
    stbvhInitStatistics(&statistics);
    ASSERT_EQ(stbvhGetStatistics(geometry.get(), &statistics), RTC_ERROR_NONE);
    const auto built = static_cast<std::size_t>(monitor_.bytes - before);
    EXPECT_EQ(statistics.triangles, 5000u);
    EXPECT_GT(statistics.structureBytes, 5000u * 8);
    EXPECT_GE(statistics.peakBytes, statistics.structureBytes);
    EXPECT_GE(built, statistics.structureBytes / 2);
    EXPECT_LE(built, statistics.structureBytes + 4096);
    EXPECT_GT(static_cast<std::size_t>(monitor_.peak - before), built);
    ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
    EXPECT_EQ(static_cast<std::size_t>(monitor_.bytes - before), built);
    const Scene scene = new_scene(device_);
    rtcAttachGeometry(scene.get(), stbvhGetGeometry(geometry.get()));
    rtcCommitScene(scene.get());
  }
  EXPECT_EQ(monitor_.bytes, before);
}

TEST_F(PluginMemory, AMonitorThatRefusesStopsTheBuild) {
  rtcSetDeviceErrorFunction(device_.get(), ignore_error, nullptr);
  const ssize_t before = monitor_.bytes;
  OwnGeometry geometry(stbvhNewGeometry(device_.get()));
  add_meshes(geometry);
  monitor_.allocations = 0;
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  const long allocations = monitor_.allocations;
  ASSERT_GE(allocations, 2);
  for (long k = 0; k < allocations; k += 1 + allocations / 8) {
    SCOPED_TRACE(testing::Message() << "allocation " << k << " of " << allocations);
    monitor_.allocations = 0;
    monitor_.refused = false;
    monitor_.refuse_from = k;
    require_build(geometry);
    const RTCError result = stbvhCommitGeometry(geometry.get());
    monitor_.refuse_from = -1;
    if (k > 0 && !monitor_.refused) continue;  // on other threads it took fewer blocks of temporary memory
    ASSERT_EQ(result, RTC_ERROR_OUT_OF_MEMORY);
    EXPECT_STREQ(stbvhGetErrorMessage(geometry.get()),
                 "out of memory, or the device's memory monitor refused");
    EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_OUT_OF_MEMORY);
    EXPECT_EQ(monitor_.bytes, before);
  }
}

TEST_F(PluginMemory, AfterAFailedBuildTheGeometryIsEmptyUntilOneSucceeds) {
  rtcSetDeviceErrorFunction(device_.get(), ignore_error, nullptr);
  OwnGeometry geometry(stbvhNewGeometry(device_.get()));
  add_meshes(geometry);
  const Scene scene = new_scene(device_);
  rtcAttachGeometry(scene.get(), stbvhGetGeometry(geometry.get()));
  const auto count_hits = [&](bool commit_scene) {
    if (commit_scene) rtcCommitScene(scene.get());
    Random random(1);
    unsigned hits = 0;
    for (unsigned i = 0; i < 100; ++i) {
      hits += intersect(scene.get(), random_ray(random)).hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
  };
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  const unsigned hits = count_hits(true);
  EXPECT_GT(hits, 50u);
  rtcGetDeviceError(device_.get());
  monitor_.refuse_from = 0;
  require_build(geometry);
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_OUT_OF_MEMORY);
  monitor_.refuse_from = -1;
  EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_OUT_OF_MEMORY);
  EXPECT_EQ(count_hits(false), 0u);
  EXPECT_EQ(count_hits(true), 0u);
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  EXPECT_EQ(count_hits(true), hits);
}

struct Progress {
  std::atomic<int> calls{0};
  int cancel_at = -1;
  double last = 0;
  bool in_order = true;
};

bool on_progress(void* ptr, double fraction) {
  auto& progress = *static_cast<Progress*>(ptr);
  progress.in_order &= fraction >= progress.last && fraction <= 1;
  progress.last = fraction;
  return progress.calls++ != progress.cancel_at;
}

TEST_F(PluginMemory, AProgressFunctionThatReturnsFalseCancelsTheBuild) {
  const ssize_t before = monitor_.bytes;
  OwnGeometry geometry(stbvhNewGeometry(device_.get()));
  add_meshes(geometry);
  Progress all;
  ASSERT_EQ(stbvhSetGeometryProgressFunction(geometry.get(), on_progress, &all), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  ASSERT_GE(all.calls, 2);
  EXPECT_TRUE(all.in_order);
  EXPECT_EQ(all.last, 1);
  for (const int cancel_at : {0, all.calls / 2}) {
    Progress progress;
    progress.cancel_at = cancel_at;
    require_build(geometry);
    ASSERT_EQ(stbvhSetGeometryProgressFunction(geometry.get(), on_progress, &progress), RTC_ERROR_NONE);
    const RTCError error = stbvhCommitGeometry(geometry.get());
    if (progress.calls <= cancel_at) {  // how often a build asks depends on how its threads run
      ASSERT_EQ(error, RTC_ERROR_NONE);
      continue;
    }
    ASSERT_EQ(error, RTC_ERROR_CANCELLED);
    EXPECT_NE(std::string(stbvhGetErrorMessage(geometry.get())).find("cancelled"), std::string::npos);
    EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_CANCELLED);
    EXPECT_EQ(monitor_.bytes, before);
    StbvhStatistics statistics;
    stbvhInitStatistics(&statistics);
    ASSERT_EQ(stbvhGetStatistics(geometry.get(), &statistics), RTC_ERROR_NONE);
    EXPECT_EQ(statistics.triangles, 0u);
  }
  ASSERT_EQ(stbvhSetGeometryProgressFunction(geometry.get(), nullptr, nullptr), RTC_ERROR_NONE);
  EXPECT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
}

}  // namespace
}  // namespace stbvh::test
