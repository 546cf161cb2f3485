/// Rays: where a scene holds nothing that is not ours, Embree need not be asked. Streams always go to it.
#include "plugin/preload/group.h"
#include "plugin/preload/ray_calls.h"

namespace stbvh::preload {
namespace {

struct Closest {
  using Arguments = RTCIntersectFunctionNArguments;
  using Rays = RTCRayHitN;
  static constexpr auto kRays = &Arguments::rayhit;
  static void call_ours(const Arguments* arguments) { group_callbacks().intersect(arguments); }
};

struct Any {
  using Arguments = RTCOccludedFunctionNArguments;
  using Rays = RTCRayN;
  static constexpr auto kRays = &Arguments::ray;
  static void call_ours(const Arguments* arguments) { group_callbacks().occluded(arguments); }
};

/// Answers a query of `size` rays, as Embree would when it asked `published` alone.
template <typename Query>
[[gnu::noinline]] void ask(const plugin::Published& published, const int* valid, RTCScene scene,
                           RTCIntersectContext* context, void* rays, unsigned size) {
  typename Query::Arguments arguments{};
  arguments.valid = const_cast<int*>(valid);
  arguments.geometryUserPtr = const_cast<plugin::Published*>(&published);
  arguments.context = context;
  arguments.*Query::kRays = static_cast<typename Query::Rays*>(rays);
  arguments.N = size;
  answer_alone(scene, [&] { Query::call_ours(&arguments); });
}

constexpr int kValid = -1;

}  // namespace
}  // namespace stbvh::preload

using stbvh::preload::answers_alone;
using stbvh::preload::Any;
using stbvh::preload::ask;
using stbvh::preload::Closest;
using stbvh::preload::kValid;
using stbvh::preload::real;

#define STBVH_RAY_FUNCTIONS(ONE_RAY, PACKET) \
  ONE_RAY(Closest, rtcIntersect1, RTCRayHit) \
  ONE_RAY(Any, rtcOccluded1, RTCRay)         \
  STBVH_PACKETS(PACKET, 4) STBVH_PACKETS(PACKET, 8) STBVH_PACKETS(PACKET, 16)
#define STBVH_PACKETS(PACKET, N) \
  PACKET(Closest, rtcIntersect##N, RTCRayHit##N, N) PACKET(Any, rtcOccluded##N, RTCRay##N, N)

#define STBVH_ONE_RAY(Query, name, Ray)                                              \
  static void name##_looks(RTCScene scene, RTCIntersectContext* context, Ray* ray) { \
    if (const auto* const ours = answers_alone(scene))                               \
      return ask<Query>(*ours, &kValid, scene, context, ray, 1);                     \
    real().name(scene, context, ray);                                                \
  }                                                                                  \
  STBVH_RAY_CALL(name, (RTCScene scene, RTCIntersectContext * context, Ray * ray), (scene, context, ray))
#define STBVH_PACKET(Query, name, Rays, N)                                                               \
  static void name##_looks(const int* valid, RTCScene scene, RTCIntersectContext* context, Rays* rays) { \
    if (const auto* const ours = answers_alone(scene))                                                   \
      return ask<Query>(*ours, valid, scene, context, rays, N);                                          \
    real().name(valid, scene, context, rays);                                                            \
  }                                                                                                      \
  STBVH_RAY_CALL(name, (const int* valid, RTCScene scene, RTCIntersectContext* context, Rays* rays),     \
                 (valid, scene, context, rays))

extern "C" {

STBVH_RAY_FUNCTIONS(STBVH_ONE_RAY, STBVH_PACKET)

}  // extern "C"

void stbvh::preload::look_at_rays() {
#define STBVH_LOOK(Query, name, ...) name##_call.look();
  STBVH_RAY_FUNCTIONS(STBVH_LOOK, STBVH_LOOK)
#undef STBVH_LOOK
}
