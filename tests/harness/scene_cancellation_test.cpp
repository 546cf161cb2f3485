/// Scenes are made, and read from files, until the task group around that is cancelled.
#include "harness/scenes/cancellation.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>

#include "harness/program/script.h"
#include "harness/scenes/embree_xml/embree_xml.h"
#include "harness/scenes/gltf/gltf.h"
#include "harness/scenes/obj/obj.h"
#include "harness/scenes/procedural/procedural.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

/// Whether `work` throws SceneCancelled in a task group that is cancelled before, or is not.
bool stops(const std::function<void()>& work, bool is_cancelled = true) {
  bool is_stopped = false;
  tbb::task_group group;
  group.run_and_wait([&] {
    if (is_cancelled) group.cancel();
    try {
      work();
    } catch (const SceneCancelled&) {
      is_stopped = true;
    }
  });
  return is_stopped;
}

TEST(SceneCancellation, LoopsAreNeverLeftHalfDone) {
  constexpr std::size_t kCount = 100'000;
  for (const std::size_t last : {std::size_t{0}, std::size_t{777}, kCount - 1, kCount}) {
    std::atomic<std::size_t> done{0};
    tbb::task_group group;
    bool is_ended = false, is_stopped = false;
    group.run_and_wait([&] {
      try {
        for_all(kCount, [&](std::size_t i) {
          if (i == last) group.cancel();
          ++done;
        });
        is_ended = true;
      } catch (const SceneCancelled&) {
        is_stopped = true;
      }
    });
    EXPECT_NE(is_ended, is_stopped);
    EXPECT_EQ(is_stopped, last < kCount) << last;
    EXPECT_TRUE(is_stopped || done == kCount) << done;
  }
}

TEST(SceneCancellation, StopsEachBuiltInScene) {
  for (const ProceduralScene& scene : procedural_scenes()) {
    const auto make = [&] { scene.make(1e-3, 1); };
    EXPECT_TRUE(stops(make)) << scene.name;
    EXPECT_FALSE(stops(make, false)) << scene.name;
  }
}

TEST(SceneCancellation, StopsTheReadingOfFiles) {
  const TemporaryFolder folder;
  const std::filesystem::path obj = folder.path() / "a.obj", xml = folder.path() / "a.xml";
  std::ofstream(obj) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  std::ofstream(xml) << "<?xml version=\"1.0\"?>\n<scene><TriangleMesh><positions>0 0 0  1 0 0  0 1 0"
                        "</positions><triangles>0 1 2</triangles></TriangleMesh></scene>\n";
  for (const std::function<void()>& read :
       {std::function<void()>([&] { load_obj(obj.string()); }),
        std::function<void()>([&] { load_embree_xml(xml); }),
        std::function<void()>([] { load_gltf(STBVH_SOURCE_DIR "/data/bending_tube.glb"); })}) {
    EXPECT_TRUE(stops(read));
    EXPECT_FALSE(stops(read, false));
  }
}

/// Those that read shots, too.
TEST(SceneCancellation, EndsPrograms) {
  const auto run = [](const char* seconds) {
    return [=] {
      const auto end = run_program({"sleep", seconds});
      EXPECT_TRUE(end && end->exit_code == 0);
    };
  };
  EXPECT_TRUE(stops(run("3600")));
  EXPECT_FALSE(stops(run("0.1"), false));
}

}  // namespace
}  // namespace stbvh::harness
