#include <fmt/format.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "harness/microbenchmarks/benchmarks.h"
#include "harness/structures/embree_device.h"
#include "harness/structures/embree_structure.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kRays = 4096;

/// A scene of one user geometry whose callbacks only count how often they are called; without one if it has
/// no steps.
class EmptyGeometry {
 public:
  explicit EmptyGeometry(unsigned steps) : device_("", 1), scene_(device_.new_scene(RTC_SCENE_FLAG_NONE)) {
    if (steps > 0) attach(steps);
    rtcCommitScene(scene_.get());
    device_.check();
  }

  RTCScene scene() const { return scene_.get(); }
  std::size_t calls() const { return calls_; }

 private:
  void attach(unsigned steps) {
    const GeometryPtr geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
    rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
    rtcSetGeometryTimeStepCount(geometry.get(), steps);
    rtcSetGeometryUserData(geometry.get(), &calls_);
    rtcSetGeometryBoundsFunction(
        geometry.get(),
        [](const RTCBoundsFunctionArguments* arguments) {
          *arguments->bounds_o = {-1, -1, -1, 0, 1, 1, 1, 0};
        },
        nullptr);
    rtcSetGeometryIntersectFunction(geometry.get(), [](const RTCIntersectFunctionNArguments* arguments) {
      ++*static_cast<std::size_t*>(arguments->geometryUserPtr);
    });
    rtcSetGeometryOccludedFunction(geometry.get(), [](const RTCOccludedFunctionNArguments* arguments) {
      ++*static_cast<std::size_t*>(arguments->geometryUserPtr);
    });
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene_.get(), geometry.get());
  }

  std::size_t calls_ = 0;
  EmbreeDevice device_;
  ScenePtr scene_;
};

/// Rays that all meet the geometry's box.
std::vector<Ray> rays_from_inside() {
  std::vector<Ray> rays(kRays);
  for (std::size_t i = 0; i < kRays; ++i) {
    const float x = static_cast<float>(i) / static_cast<float>(kRays);
    rays[i] = {.origin = {x - 0.5f, 0.5f - x, 0.25f * x},
               .tnear = 0,
               .direction = {0.5f - x, 0.3f, i % 2 == 0 ? x : -x},
               .time = x,
               .tfar = std::numeric_limits<float>::infinity(),
               .mask = 0xFFFFFFFFu};
  }
  return rays;
}

void register_scene(std::string_view scene, unsigned steps) {
  const auto geometry = std::make_shared<const EmptyGeometry>(steps);
  using Trace = void (*)(RTCScene, std::span<const Ray>, std::span<HitRecord>);
  constexpr std::pair<const char*, Trace> kQueries[] = {{"closest", &intersect_scene},
                                                        {"any", &occluded_scene}};
  for (const auto& [query, trace] : kQueries) {
    const std::string name = fmt::format("embree/{}/{}", scene, query);
    benchmark::RegisterBenchmark(name.c_str(), [=, trace = trace](benchmark::State& state) {
      const std::vector<Ray> rays = rays_from_inside();
      std::vector<HitRecord> records(kRays);
      const std::size_t before = geometry->calls();
      while (state.KeepRunningBatch(kRays)) trace(geometry->scene(), rays, records);
      const std::size_t expected = steps > 0 ? static_cast<std::size_t>(state.iterations()) : 0;
      if (geometry->calls() - before != expected) report_wrong_answer(state);
    });
  }
}

}  // namespace

void register_embree_calls() {
  register_scene("empty_scene", 0);
  register_scene("empty_callback", 1);
  register_scene("empty_callback_moving", 2);
}

}  // namespace stbvh::harness
