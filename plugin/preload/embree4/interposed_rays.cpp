/// Rays. An application may bring the callback of all user geometries with a ray, and would be asked for ours
/// then. And where a scene holds nothing that is not ours, Embree need not be asked.
#include "plugin/preload/ray_calls.h"

namespace stbvh::preload {
namespace {

using plugin::Published;

struct Closest : ClosestQuery {
  using Options = RTCIntersectArguments;
  using Function = RTCIntersectFunctionN;
  static constexpr auto kInitialise = rtcInitIntersectArguments;
  static constexpr auto kFunction = &Options::intersect;
};

struct Any : AnyQuery {
  using Options = RTCOccludedArguments;
  using Function = RTCOccludedFunctionN;
  static constexpr auto kInitialise = rtcInitOccludedArguments;
  static constexpr auto kFunction = &Options::occluded;
};

/// The options of a query whose callback for user geometries is the application's, with ours in its place.
template <typename Query>
struct Rerouted : Query::Options {
  explicit Rerouted(typename Query::Options& given)
      : Query::Options(given), application(given.*Query::kFunction) {
    this->*Query::kFunction = call;
  }

  /// Embree's callback for all user geometries.
  static void call(const typename Query::Arguments* arguments) {
    if (is_group(arguments->geometryUserPtr)) return Query::call_ours(arguments);
    const auto& options = plugin::options_behind<typename Query::Options>(arguments);
    static_cast<const Rerouted&>(options).application(arguments);
  }

  float min_width_distance_factor = 0;  ///< read by an Embree that was built with RTC_MIN_WIDTH
  typename Query::Function application;
};

/// Answers as Embree would when it asked `published` alone.
template <typename Query>
void ask(const Published& published, const int* valid, void* rays, unsigned size,
         typename Query::Options* options) {
  static const typename Query::Options kPlain = [] {
    typename Query::Options plain;
    Query::kInitialise(&plain);
    return plain;
  }();
  plugin::QueryContext plain_context = plugin::new_context();
  plugin::ArgumentsWithOptions<typename Query::Arguments, typename Query::Options> arguments{};
  arguments.options = options == nullptr ? &kPlain : options;
  arguments.arguments =
      arguments_for<Query>(published, valid, plugin::context_of(options, plain_context), rays, size);
  Query::call_ours(&arguments.arguments);
}

/// A query of `size` rays where there are groups; `native` is Embree's own, with the options that it is
/// given.
template <typename Query, typename Native>
void query(const int* valid, void* scene, void* rays, unsigned size, typename Query::Options* options,
           Native&& native) {
  if (const Published* const published = answers_alone(static_cast<RTCScene>(scene))) {
    return answer_alone(static_cast<RTCScene>(scene),
                        [&] { ask<Query>(*published, valid, rays, size, options); });
  }
  const auto function = options == nullptr ? nullptr : options->*Query::kFunction;
  if (function == nullptr || function == Rerouted<Query>::call) return native(options);
  Rerouted<Query> rerouted(*options);
  native(&rerouted);
}

}  // namespace
}  // namespace stbvh::preload

using stbvh::preload::Any;
using stbvh::preload::Closest;
using stbvh::preload::kValid;
using stbvh::preload::query;
using stbvh::preload::real;

// Later versions of Embree 4 have two functions for each query, of which the second takes what is the scene
// on CPUs.
#define STBVH_RAY_FUNCTIONS(ONE_RAY, PACKET)                                                   \
  ONE_RAY(Closest, rtcIntersect1, RTCRayHit, RTCScene, RTCIntersectArguments)                  \
  ONE_RAY(Closest, rtcTraversableIntersect1, RTCRayHit, RTCTraversable, RTCIntersectArguments) \
  ONE_RAY(Any, rtcOccluded1, RTCRay, RTCScene, RTCOccludedArguments)                           \
  ONE_RAY(Any, rtcTraversableOccluded1, RTCRay, RTCTraversable, RTCOccludedArguments)          \
  STBVH_PACKETS(PACKET, 4) STBVH_PACKETS(PACKET, 8) STBVH_PACKETS(PACKET, 16)
#define STBVH_PACKETS(PACKET, N)                                                                      \
  PACKET(Closest, rtcIntersect##N, RTCRayHit##N, N, RTCScene, RTCIntersectArguments)                  \
  PACKET(Closest, rtcTraversableIntersect##N, RTCRayHit##N, N, RTCTraversable, RTCIntersectArguments) \
  PACKET(Any, rtcOccluded##N, RTCRay##N, N, RTCScene, RTCOccludedArguments)                           \
  PACKET(Any, rtcTraversableOccluded##N, RTCRay##N, N, RTCTraversable, RTCOccludedArguments)

#define STBVH_ONE_RAY(Query, name, Ray, Handle, Options)                                                    \
  static void name##_looks(Handle scene, Ray* ray, Options* options) {                                      \
    query<Query>(&kValid, scene, ray, 1, options, [=](Options* given) { real().name(scene, ray, given); }); \
  }                                                                                                         \
  STBVH_RAY_CALL(name, (Handle scene, Ray * ray, Options * options), (scene, ray, options))
#define STBVH_PACKET(Query, name, Rays, N, Handle, Options)                                \
  static void name##_looks(const int* valid, Handle scene, Rays* rays, Options* options) { \
    query<Query>(valid, scene, rays, N, options,                                           \
                 [=](Options* given) { real().name(valid, scene, rays, given); });         \
  }                                                                                        \
  STBVH_RAY_CALL(name, (const int* valid, Handle scene, Rays* rays, Options* options),     \
                 (valid, scene, rays, options))

extern "C" {

STBVH_RAY_FUNCTIONS(STBVH_ONE_RAY, STBVH_PACKET)

}  // extern "C"

void stbvh::preload::look_at_rays() {
#define STBVH_LOOK(Query, name, ...) name##_call.look();
  STBVH_RAY_FUNCTIONS(STBVH_LOOK, STBVH_LOOK)
#undef STBVH_LOOK
}
