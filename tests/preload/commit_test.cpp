/// Commits: several threads, monitors, cancelled builds, and everything in odd orders many times.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <mutex>
#include <thread>

#include "plugin/preload/environment.h"
#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

/// What a device's memory monitor was told, and the errors of a device.
struct Watched {
  Watched() : device(ours().rtcNewDevice(nullptr)) {
    ours().rtcSetDeviceErrorFunction(device, on_error, this);
    ours().rtcSetDeviceMemoryMonitorFunction(device, on_memory, this);
  }
  ~Watched() { ours().rtcReleaseDevice(device); }

  static void on_error(void* self, RTCError code, const char* message) {
    EXPECT_NE(message, nullptr);
    const std::lock_guard lock(static_cast<Watched*>(self)->mutex);
    static_cast<Watched*>(self)->errors.push_back(code);
  }
  static bool on_memory(void* user, ssize_t bytes, bool post) {
    Watched& self = *static_cast<Watched*>(user);
    if (bytes > 0 && !post && self.in_use + bytes > self.limit) return false;
    const ssize_t now = self.in_use += bytes;
    ssize_t peak = self.peak;
    while (now > peak && !self.peak.compare_exchange_weak(peak, now)) {
    }
    EXPECT_GE(now, 0);
    return true;
  }

  RTCDevice device;
  std::mutex mutex;
  std::vector<RTCError> errors;
  std::atomic<ssize_t> in_use{0}, peak{0}, limit{std::numeric_limits<ssize_t>::max()};
};

RTCScene scene_of(RTCDevice device, const std::vector<Mesh>& meshes) {
  const RTCScene scene = ours().rtcNewScene(device);
  for (const Mesh& mesh : meshes) attach(ours(), scene, new_mesh(ours(), device, mesh));
  return scene;
}

TEST(PreloadCommit, JoinedBySeveralThreads) {
  const std::vector<Mesh> meshes{triangle_soup(1, 3000, 5), triangle_soup(2, 2000, 1),
                                 triangle_soup(3, 2000, 9)};
  Twice twice;
  for (const Mesh& mesh : meshes) twice.add(mesh);
  native().rtcCommitScene(twice.native_scene);
  for (int round = 0; round < 5; ++round) {
    std::vector<std::thread> threads;
    for (int i = 0; i < 6; ++i) {
      threads.emplace_back([&] {
        ours().rtcJoinCommitScene(twice.our_scene);
        // Who returns may trace.
        EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.5f), geom_id_hit(twice.native_scene, 0, 0, 0.5f));
      });
    }
    for (std::thread& thread : threads) thread.join();
    expect_same_hits(twice.our_scene, twice.native_scene, random_rays(3, 200));
    ours().rtcCommitGeometry(ours().rtcGetGeometry(twice.our_scene, 0));
  }
}

/// Embree takes a scene with a switched-off mesh for modified at every commit, so a late thread would build
/// again.
TEST(PreloadCommit, BuildsNothingAfterOneOfItsThreadsHasReturned) {
  const std::vector<Mesh> meshes{triangle_soup(1, 20, 3), triangle_soup(2, 20, 1)};
  Watched watched;
  const RTCScene scene = scene_of(watched.device, meshes);
  struct {
    std::atomic<bool> has_returned = false;
    std::atomic<int> late_calls = 0;
  } seen;
  ours().rtcSetSceneProgressMonitorFunction(
      scene,
      [](void* user, double) {
        auto& now = *static_cast<decltype(seen)*>(user);
        if (now.has_returned) ++now.late_calls;
        return true;
      },
      &seen);
  for (int round = 0; round < 500; ++round) {
    seen.has_returned = false;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        ours().rtcJoinCommitScene(scene);
        seen.has_returned = true;
      });
    }
    for (std::thread& thread : threads) thread.join();
    ours().rtcCommitGeometry(ours().rtcGetGeometry(scene, 0));
  }
  EXPECT_EQ(seen.late_calls, 0);
  ours().rtcReleaseScene(scene);
}

TEST(PreloadCommit, JoinedByTasksOfTheApplication) {
  const std::vector<Mesh> meshes{triangle_soup(1, 4000, 5), triangle_soup(2, 4000, 3)};
  Twice twice;
  for (const Mesh& mesh : meshes) twice.add(mesh);
  native().rtcCommitScene(twice.native_scene);
  for (int round = 0; round < 10; ++round) {
    // A thread that waits inside a build must not start another of these tasks, which would wait for it.
    tbb::parallel_for(
        tbb::blocked_range<int>(0, 16, 1),
        [&](const tbb::blocked_range<int>&) { ours().rtcJoinCommitScene(twice.our_scene); },
        tbb::simple_partitioner());
    EXPECT_TRUE(is_taken_over(twice.our_scene));
    ours().rtcCommitGeometry(ours().rtcGetGeometry(twice.our_scene, 0));
  }
  ours().rtcCommitScene(twice.our_scene);
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(3, 200));
}

TEST(PreloadCommit, OfDifferentScenesAtOnce) {
  const std::vector<Mesh> meshes{triangle_soup(1, 500, 4), triangle_soup(2, 400, 2)};
  Twice twice;
  for (const Mesh& mesh : meshes) twice.add(mesh);
  twice.commit();
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int round = 0; round < 10; ++round) {
        const RTCScene scene = scene_of(twice.our_device, meshes);
        ours().rtcCommitScene(scene);
        EXPECT_TRUE(is_taken_over(scene));
        expect_same_hits(scene, twice.native_scene, random_rays(5, 50));
        ours().rtcReleaseScene(scene);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(PreloadCommit, WithoutChangesDoesNothing) {
  const std::vector<Mesh> meshes{triangle_soup(1, 100, 3), triangle_soup(2, 100, 1)};
  Watched watched;
  const RTCScene scene = scene_of(watched.device, meshes);
  std::atomic<int> calls = 0;
  ours().rtcSetSceneProgressMonitorFunction(
      scene, [](void* count, double) { return ++*static_cast<std::atomic<int>*>(count) > 0; }, &calls);
  ours().rtcCommitScene(scene);
  EXPECT_GT(calls, 0);
  calls = 0;
  ours().rtcCommitScene(scene);
  EXPECT_EQ(calls, 0);
  ours().rtcCommitGeometry(ours().rtcGetGeometry(scene, 1));  // the still one: Embree's to build
  ours().rtcCommitScene(scene);
  EXPECT_GT(calls, 0);
  calls = 0;
  ours().rtcDisableGeometry(ours().rtcGetGeometry(scene, 0));
  ours().rtcCommitScene(scene);
  EXPECT_GT(calls, 0);
  ours().rtcReleaseScene(scene);
}

TEST(PreloadMonitors, ProgressGrowsToOne) {
  const std::vector<Mesh> meshes{triangle_soup(1, 20000, 4), triangle_soup(2, 20000, 1)};
  Watched watched;
  const RTCScene scene = scene_of(watched.device, meshes);
  struct Progress {
    std::mutex mutex;
    double last = 0;
    int calls = 0;
  } progress;
  ours().rtcSetSceneProgressMonitorFunction(
      scene,
      [](void* user, double fraction) {
        auto& p = *static_cast<Progress*>(user);
        const std::lock_guard lock(p.mutex);
        EXPECT_GE(fraction, 0);
        EXPECT_LE(fraction, 1.0001);
        p.last = std::max(p.last, fraction);
        ++p.calls;
        return true;
      },
      &progress);
  ours().rtcCommitScene(scene);
  EXPECT_GE(progress.calls, 4);  // at least: how often a build asks depends on how its threads run
  EXPECT_GT(progress.last, 0.9);
  ours().rtcReleaseScene(scene);
}

TEST(PreloadMonitors, ACancelledBuildReportsOneErrorAndLeaksNothing) {
  const std::vector<Mesh> meshes{triangle_soup(1, 6000, 4), triangle_soup(2, 2000, 1)};
  Watched watched;
  const RTCScene scene = scene_of(watched.device, meshes);
  std::atomic<int> calls_left = 0;
  ours().rtcSetSceneProgressMonitorFunction(
      scene, [](void* left, double) { return (*static_cast<std::atomic<int>*>(left))-- > 0; }, &calls_left);
  int cancelled = 0;
  for (int calls = 0; calls < 8; ++calls) {
    watched.errors.clear();
    calls_left = calls;
    ours().rtcCommitScene(scene);
    // How often a build asks depends on how its threads run.
    if (calls_left >= 0) {
      EXPECT_TRUE(watched.errors.empty());
      ours().rtcCommitGeometry(ours().rtcGetGeometry(scene, 0));
      continue;
    }
    ++cancelled;
    ASSERT_EQ(watched.errors, std::vector<RTCError>{RTC_ERROR_CANCELLED}) << calls;
    EXPECT_EQ(ours().rtcGetDeviceError(watched.device), RTC_ERROR_CANCELLED);
    EXPECT_EQ(ours().rtcGetDeviceError(watched.device), RTC_ERROR_NONE);
    // As with Embree alone: a ray hits nothing and does no harm, though it may be an error.
    EXPECT_FALSE(hits(scene, meshes[0].steps[0][0].x, meshes[0].steps[0][0].y, 0));
    ours().rtcGetDeviceError(watched.device);
  }
  EXPECT_GE(cancelled, 3);
  calls_left = 1 << 30;
  watched.errors.clear();
  ours().rtcCommitScene(scene);
  EXPECT_TRUE(watched.errors.empty());
  EXPECT_TRUE(is_taken_over(scene));
  ours().rtcReleaseScene(scene);
  EXPECT_EQ(watched.in_use, 0);
}

TEST(PreloadMonitors, ACancelledCommitOfASceneWhoseMovingMeshesAreGoneDoesNoHarm) {
  const std::vector<Mesh> meshes{triangle_soup(1, 200, 4), triangle_soup(2, 200, 1)};
  const auto refuse = [](void*, double) { return false; };
  for (const bool detaches : {false, true}) {
    Watched watched;
    const RTCScene scene = scene_of(watched.device, meshes);
    ours().rtcCommitScene(scene);
    EXPECT_TRUE(is_taken_over(scene));
    detaches ? ours().rtcDetachGeometry(scene, 0)
             : ours().rtcDisableGeometry(ours().rtcGetGeometry(scene, 0));
    ours().rtcSetSceneProgressMonitorFunction(scene, refuse, nullptr);
    ours().rtcCommitScene(scene);
    EXPECT_EQ(watched.errors, std::vector<RTCError>{RTC_ERROR_CANCELLED});
    // Of its trees Embree may keep the one that names our geometry.
    for (int i = 0; i < 50; ++i) hits(scene, 0.04f * static_cast<float>(i) - 1.0f, 0, 0.5f);
    ours().rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
    ours().rtcGetDeviceError(watched.device);
    watched.errors.clear();
    ours().rtcCommitScene(scene);
    EXPECT_EQ(is_taken_over(scene), preload::environment().all_triangles);  // the still one
    if (detaches) {
      attach(ours(), scene, new_mesh(ours(), watched.device, meshes[0]));
    } else {
      ours().rtcEnableGeometry(ours().rtcGetGeometry(scene, 0));
    }
    ours().rtcCommitScene(scene);
    EXPECT_TRUE(is_taken_over(scene));
    EXPECT_TRUE(watched.errors.empty());
    Twice reference;
    for (const Mesh& mesh : meshes) reference.add(mesh);
    reference.commit();
    expect_same_hits(scene, reference.native_scene, random_rays(4, 500));
    ours().rtcReleaseScene(scene);
    EXPECT_EQ(watched.in_use, 0);
  }
}

TEST(PreloadMonitors, RefusedMemoryReportsOneErrorAndLeaksNothing) {
  const std::vector<Mesh> meshes{triangle_soup(1, 6000, 4), triangle_soup(2, 2000, 1)};
  Watched watched;
  const RTCScene scene = scene_of(watched.device, meshes);
  ours().rtcCommitScene(scene);
  const ssize_t peak = watched.peak;
  EXPECT_GT(peak, 1 << 18);
  int failed = 0;
  for (int part = 0; part < 12; ++part) {
    ours().rtcCommitGeometry(ours().rtcGetGeometry(scene, 0));
    watched.limit = watched.in_use / 4 + peak * part / 12;
    watched.errors.clear();
    ours().rtcCommitScene(scene);
    if (!watched.errors.empty()) {
      EXPECT_EQ(watched.errors, std::vector<RTCError>{RTC_ERROR_OUT_OF_MEMORY}) << part;
      ++failed;
    }
    const RTCError code = ours().rtcGetDeviceError(watched.device);
    EXPECT_EQ(code, watched.errors.empty() ? RTC_ERROR_NONE : RTC_ERROR_OUT_OF_MEMORY);
    hits(scene, 0, 0, 0.5f);
    ours().rtcGetDeviceError(watched.device);
  }
  EXPECT_GT(failed, 0);
  watched.limit = std::numeric_limits<ssize_t>::max();
  watched.errors.clear();
  ours().rtcCommitScene(scene);
  EXPECT_TRUE(watched.errors.empty());
  ours().rtcReleaseScene(scene);
  EXPECT_EQ(watched.in_use, 0);
}

TEST(PreloadMonitors, AFailedJoinReportsOneError) {
  const std::vector<Mesh> meshes{triangle_soup(1, 6000, 4)};
  Watched watched;
  const RTCScene scene = scene_of(watched.device, meshes);
  std::atomic<int> started{0};
  ours().rtcSetSceneProgressMonitorFunction(
      scene,
      [](void* user, double) {
        // Cancels once all threads are there.
        return *static_cast<std::atomic<int>*>(user) < 4;
      },
      &started);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      ++started;
      ours().rtcJoinCommitScene(scene);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const RTCError error : watched.errors) EXPECT_EQ(error, RTC_ERROR_CANCELLED);
  EXPECT_LE(watched.errors.size(), 4u);
  ours().rtcReleaseScene(scene);
  EXPECT_EQ(watched.in_use, 0);
}

/// Random life of scenes, geometries and instances; each round is checked for errors, the end for bytes.
class Chaos {
 public:
  explicit Chaos(std::uint32_t seed) : random_(seed) {
    for (unsigned i = 0; i < 5; ++i) meshes_.push_back(triangle_soup(seed * 10 + i, 5 + 20 * i, 1 + i * i));
  }

  void run(int rounds) {
    for (int round = 0; round < rounds; ++round) step();
    while (!scenes_.empty()) release_scene(random_.below(static_cast<unsigned>(scenes_.size())));
    for (const RTCGeometry geometry : geometries_) ours().rtcReleaseGeometry(geometry);
    EXPECT_TRUE(watched_.errors.empty());
    EXPECT_EQ(watched_.in_use, 0);
  }

 private:
  struct SceneState {
    RTCScene scene;
    std::vector<unsigned> attached;
    bool has_instances = false;  ///< is not instanced itself: one level only
    bool is_instanced = false;
  };

  void step() {
    const unsigned action = random_.below(10);
    if (scenes_.empty() || (action == 0 && scenes_.size() < 6)) return new_scene();
    const unsigned which = random_.below(static_cast<unsigned>(scenes_.size()));
    switch (action) {
      case 1:
        return release_scene(which);
      case 2:
      case 3:
        return attach_mesh(scenes_[which]);
      case 4:
        return detach(scenes_[which]);
      case 5:
        return instance(scenes_[which]);
      case 6:
        return cancel(scenes_[which]);
      case 7:
        return toggle(scenes_[which]);
      default:
        return commit(scenes_[which]);
    }
  }

  void new_scene() { scenes_.push_back({ours().rtcNewScene(watched_.device), {}}); }

  void release_scene(unsigned which) {
    ours().rtcReleaseScene(scenes_[which].scene);
    scenes_.erase(scenes_.begin() + which);
  }

  void attach_mesh(SceneState& state) {
    RTCGeometry geometry;
    if (!geometries_.empty() && random_.unit() < 0.3f) {
      geometry = geometries_[random_.below(static_cast<unsigned>(geometries_.size()))];  // in several scenes
    } else {
      geometry = new_mesh(ours(), watched_.device, meshes_[random_.below(5)]);
      ours().rtcCommitGeometry(geometry);
      if (random_.unit() < 0.2f) {
        ours().rtcRetainGeometry(geometry);
        geometries_.push_back(geometry);
      }
      state.attached.push_back(ours().rtcAttachGeometry(state.scene, geometry));
      return ours().rtcReleaseGeometry(geometry);
    }
    state.attached.push_back(ours().rtcAttachGeometry(state.scene, geometry));
  }

  void detach(SceneState& state) {
    if (state.attached.empty()) return;
    const unsigned which = random_.below(static_cast<unsigned>(state.attached.size()));
    ours().rtcDetachGeometry(state.scene, state.attached[which]);
    state.attached.erase(state.attached.begin() + which);
    commit(state);  // before another scene that shows this one is traced
  }

  void instance(SceneState& state) {
    SceneState& inner = scenes_[random_.below(static_cast<unsigned>(scenes_.size()))];
    if (&inner == &state || inner.has_instances || state.is_instanced) return;
    commit(inner);
    const RTCGeometry geometry = ours().rtcNewGeometry(watched_.device, RTC_GEOMETRY_TYPE_INSTANCE);
    ours().rtcSetGeometryInstancedScene(geometry, inner.scene);
    state.attached.push_back(attach(ours(), state.scene, geometry));
    state.has_instances = inner.is_instanced = true;
  }

  void toggle(SceneState& state) {
    if (state.attached.empty()) return;
    const RTCGeometry geometry = ours().rtcGetGeometry(
        state.scene, state.attached[random_.below(static_cast<unsigned>(state.attached.size()))]);
    random_.unit() < 0.5f ? ours().rtcDisableGeometry(geometry) : ours().rtcEnableGeometry(geometry);
  }

  void commit(SceneState& state) {
    if (random_.unit() < 0.5f) {
      ours().rtcCommitScene(state.scene);
    } else {
      std::thread other([&] { ours().rtcJoinCommitScene(state.scene); });
      ours().rtcJoinCommitScene(state.scene);
      other.join();
    }
    for (int i = 0; i < 5; ++i)
      hits(state.scene, random_.between(-1, 1), random_.between(-1, 1), random_.unit());
    if (random_.unit() < 0.2f) {
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      RTCPointQuery query{0, 0, 0, 0, 0.1f};
      ours().rtcPointQuery(
          state.scene, &query, &context, [](RTCPointQueryFunctionArguments*) { return false; }, nullptr);
    }
  }

  void cancel(SceneState& state) {
    ours().rtcSetSceneProgressMonitorFunction(
        state.scene, [](void*, double) { return false; }, nullptr);
    ours().rtcCommitScene(state.scene);
    ours().rtcSetSceneProgressMonitorFunction(state.scene, nullptr, nullptr);
    EXPECT_LE(watched_.errors.size(), 1u);
    for (const RTCError error : watched_.errors) EXPECT_EQ(error, RTC_ERROR_CANCELLED);
    // Not traced before the next commit: here Embree 3.13.5 itself may read the trees that it has freed,
    // where meshes stay native.
    watched_.errors.clear();
    ours().rtcGetDeviceError(watched_.device);
    ours().rtcCommitScene(state.scene);
  }

  Random random_;
  Watched watched_;
  std::vector<Mesh> meshes_;
  std::vector<SceneState> scenes_;
  std::vector<RTCGeometry> geometries_;
};

TEST(PreloadChaos, LeavesNoErrorAndNoByte) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) Chaos(seed).run(150);
}

TEST(PreloadChaos, OnSeveralThreads) {
  std::vector<std::thread> threads;
  for (std::uint32_t seed = 100; seed < 104; ++seed) {
    threads.emplace_back([seed] {
      for (std::uint32_t i = 0; i < 3; ++i) Chaos(seed + 10 * i).run(100);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace stbvh::preload_test
