/// Calls that trace rays: straight on to Embree until there is a group, looked at from then on.
#pragma once

#include <atomic>
#include <new>

#include "plugin/preload/group.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/scene_changes.h"
#include "plugin/preload/tracked_scene.h"

namespace stbvh::preload {

/// Where a ray function of the application's goes: to Embree's own without a look, as long as there is no
/// group. Until Embree is found it goes to `first`.
template <typename Function>
class RayCall {
 public:
  constexpr RayCall(Function* first, Function* looks) : target_(first), first_(first), looks_(looks) {}

  Function* target() const { return target_.load(std::memory_order_relaxed); }
  void pass_on_to(Function* embrees) {
    Function* expected = first_;
    target_.compare_exchange_strong(expected, embrees, std::memory_order_relaxed);
  }
  void look() { target_.store(looks_, std::memory_order_relaxed); }

 private:
  std::atomic<Function*> target_;
  Function *first_, *looks_;
};

/// A query as a user geometry of Embree is asked it.
struct ClosestQuery {
  using Arguments = RTCIntersectFunctionNArguments;
  using Rays = RTCRayHitN;
  static constexpr auto kRays = &Arguments::rayhit;
  static void call_ours(const Arguments* arguments) { group_callbacks().intersect(arguments); }
};

struct AnyQuery {
  using Arguments = RTCOccludedFunctionNArguments;
  using Rays = RTCRayN;
  static constexpr auto kRays = &Arguments::ray;
  static void call_ours(const Arguments* arguments) { group_callbacks().occluded(arguments); }
};

/// What it is asked where Embree would ask `published` alone.
template <typename Query>
typename Query::Arguments arguments_for(const plugin::Published& published, const int* valid,
                                        plugin::QueryContext* context, void* rays, unsigned size) {
  typename Query::Arguments arguments{};
  arguments.valid = const_cast<int*>(valid);
  arguments.geometryUserPtr = const_cast<plugin::Published*>(&published);
  arguments.context = context;
  arguments.*Query::kRays = static_cast<typename Query::Rays*>(rays);
  arguments.N = size;
  return arguments;
}

/// Of a query of one ray.
inline constexpr int kValid = -1;

/// Apart from what is done for each ray, as is all that needs registers.
[[gnu::noinline, gnu::cold]] inline const plugin::Published* find_what_answers_alone(RTCScene scene) {
  const auto tracked = scenes().find(scene);
  return tracked == nullptr ? nullptr : tracked->answers_alone();
}

/// What answers for all of the scene, or null.
inline const plugin::Published* answers_alone(RTCScene scene) {
  constinit thread_local SceneAnswers<const plugin::Published*> answers;
  return answers.of(scene, [=] { return find_what_answers_alone(scene); });
}

/// Runs ask(). What a filter of the application throws becomes an error, as in Embree.
template <typename Ask>
void answer_alone(RTCScene scene, const Ask& ask) {
  const auto raise = [=](RTCError code, const char* message) {
    if (const auto tracked = scenes().find(scene)) tracked->device()->raise(code, message);
  };
  try {
    ask();
  } catch (const std::bad_alloc&) {
    raise(RTC_ERROR_OUT_OF_MEMORY, "out of memory");
  } catch (...) {
    raise(RTC_ERROR_UNKNOWN, "unknown exception caught");
  }
}

}  // namespace stbvh::preload

/// Defines the function `name` of Embree, which leads to name##_looks(...) once there is a group.
#define STBVH_RAY_CALL(name, parameters, arguments)                                                  \
  static void name##_first parameters;                                                               \
  static constinit stbvh::preload::RayCall<void parameters> name##_call{name##_first, name##_looks}; \
  static void name##_first parameters {                                                              \
    name##_call.pass_on_to(stbvh::preload::real().name);                                             \
    name##_call.target() arguments;                                                                  \
  }                                                                                                  \
  void name parameters {                                                                             \
    name##_call.target() arguments;                                                                  \
  }
