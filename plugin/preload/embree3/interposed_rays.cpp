/// Rays: where a scene holds nothing that is not ours, Embree need not be asked. Streams always go to it.
#include "plugin/preload/ray_calls.h"

namespace stbvh::preload {
namespace {

/// Answers a query of `size` rays, as Embree would when it asked `published` alone.
template <typename Query>
[[gnu::noinline]] void ask(const plugin::Published& published, const int* valid, RTCScene scene,
                           RTCIntersectContext* context, void* rays, unsigned size) {
  const auto arguments = arguments_for<Query>(published, valid, context, rays, size);
  answer_alone(scene, [&] { Query::call_ours(&arguments); });
}

/// How many rays the scene's device traces side by side at most. Embree cuts wider packets up, and then does
/// not look at which lanes are valid: those are left to it.
[[gnu::noinline, gnu::cold]] unsigned find_widest_packet(RTCScene scene) {
  const auto tracked = scenes().find(scene);
  if (tracked == nullptr) return 0;
  const auto supports = [&](RTCDeviceProperty property) {
    return real().rtcGetDeviceProperty(tracked->device()->handle(), property) != 0;
  };
  if (supports(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
  if (supports(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return 8;
  return supports(RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED) ? 4 : 0;
}

/// What answers for all of the scene where it is asked with packets of that size, or null.
const plugin::Published* answers_packets_alone(RTCScene scene, unsigned size) {
  constinit thread_local SceneAnswers<unsigned> widest_packets;
  const unsigned widest = widest_packets.of(scene, [=] { return find_widest_packet(scene); });
  return size <= widest ? answers_alone(scene) : nullptr;
}

}  // namespace
}  // namespace stbvh::preload

using stbvh::preload::answers_alone;
using stbvh::preload::answers_packets_alone;
using stbvh::preload::AnyQuery;
using stbvh::preload::ask;
using stbvh::preload::ClosestQuery;
using stbvh::preload::kValid;
using stbvh::preload::real;

#define STBVH_RAY_FUNCTIONS(ONE_RAY, PACKET)      \
  ONE_RAY(ClosestQuery, rtcIntersect1, RTCRayHit) \
  ONE_RAY(AnyQuery, rtcOccluded1, RTCRay)         \
  STBVH_PACKETS(PACKET, 4) STBVH_PACKETS(PACKET, 8) STBVH_PACKETS(PACKET, 16)
#define STBVH_PACKETS(PACKET, N) \
  PACKET(ClosestQuery, rtcIntersect##N, RTCRayHit##N, N) PACKET(AnyQuery, rtcOccluded##N, RTCRay##N, N)

#define STBVH_ONE_RAY(Query, name, Ray)                                              \
  static void name##_looks(RTCScene scene, RTCIntersectContext* context, Ray* ray) { \
    if (const auto* const ours = answers_alone(scene))                               \
      return ask<Query>(*ours, &kValid, scene, context, ray, 1);                     \
    real().name(scene, context, ray);                                                \
  }                                                                                  \
  STBVH_RAY_CALL(name, (RTCScene scene, RTCIntersectContext * context, Ray * ray), (scene, context, ray))
#define STBVH_PACKET(Query, name, Rays, N)                                                               \
  static void name##_looks(const int* valid, RTCScene scene, RTCIntersectContext* context, Rays* rays) { \
    if (const auto* const ours = answers_packets_alone(scene, N))                                        \
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
