/// Queries of either Embree, written once: what one takes in a context the other takes in arguments.
#pragma once

#include <cstddef>
#include <type_traits>

#include "plugin/embree_api.h"

namespace stbvh::test {

using plugin::kSceneTakesQueryFilters;
using plugin::new_context;
using plugin::QueryContext;

/// Floats of a RTCRayHit and of each lane of a packet, without the padding at the end.
constexpr std::size_t kRayHitMembers = (offsetof(RTCRayHit, hit) + offsetof(RTCHit, instID)) / sizeof(float) +
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
                                       2 * RTC_MAX_INSTANCE_LEVEL_COUNT;
#else
                                       RTC_MAX_INSTANCE_LEVEL_COUNT;
#endif

/// What a query brings with it besides rays. One that brings nothing gives a null, where a null is taken.
struct QueryOptions {
  QueryContext* context = nullptr;
  RTCFilterFunctionN filter = nullptr;
  bool filters_all_meshes = true;  ///< else only those that ask for it, of which Embree 3 knows none
  bool coherent = false;
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectFunctionN intersect = nullptr;  ///< of all user geometries
  RTCOccludedFunctionN occluded = nullptr;
#endif
};

#if RTC_VERSION_MAJOR >= 4

/// The arguments of one query, or none.
template <typename Arguments, void (*kInitialise)(Arguments*)>
class ArgumentsOf {
 public:
  explicit ArgumentsOf(const QueryOptions& options)
      : brings_nothing_(options.context == nullptr && options.filter == nullptr && !options.coherent &&
                        options.intersect == nullptr && options.occluded == nullptr) {
    kInitialise(&arguments_);
    unsigned flags = options.coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    if (options.filters_all_meshes) flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    arguments_.flags = static_cast<RTCRayQueryFlags>(flags);
    arguments_.context = options.context;
    arguments_.filter = options.filter;
    if constexpr (std::is_same_v<Arguments, RTCIntersectArguments>) {
      arguments_.intersect = options.intersect;
    } else {
      arguments_.occluded = options.occluded;
    }
  }
  Arguments* get() { return brings_nothing_ ? nullptr : &arguments_; }

 private:
  bool brings_nothing_;
  Arguments arguments_;
};
using IntersectArguments = ArgumentsOf<RTCIntersectArguments, rtcInitIntersectArguments>;
using OccludedArguments = ArgumentsOf<RTCOccludedArguments, rtcInitOccludedArguments>;

inline void intersect_one(RTCScene scene, RTCRayHit& ray, const QueryOptions& options = {}) {
  rtcIntersect1(scene, &ray, IntersectArguments(options).get());
}
inline void occluded_one(RTCScene scene, RTCRay& ray, const QueryOptions& options = {}) {
  rtcOccluded1(scene, &ray, OccludedArguments(options).get());
}
inline void intersect_one(StbvhGeometry geometry, RTCRayHit& ray, const QueryOptions& options = {}) {
  stbvhIntersect1(geometry, &ray, IntersectArguments(options).get());
}
inline void occluded_one(StbvhGeometry geometry, RTCRay& ray, const QueryOptions& options = {}) {
  stbvhOccluded1(geometry, &ray, OccludedArguments(options).get());
}
inline void intersect_many(StbvhGeometry geometry, RTCRayHit* rays, std::size_t count, std::size_t stride,
                           const QueryOptions& options = {}) {
  stbvhIntersectN(geometry, rays, count, stride, IntersectArguments(options).get());
}
inline void occluded_many(StbvhGeometry geometry, RTCRay* rays, std::size_t count, std::size_t stride,
                          const QueryOptions& options = {}) {
  stbvhOccludedN(geometry, rays, count, stride, OccludedArguments(options).get());
}

#define STBVH_TEST_PACKETS(N)                                                          \
  inline void intersect_packet(const int* valid, RTCScene scene, RTCRayHit##N& packet, \
                               const QueryOptions& options = {}) {                     \
    rtcIntersect##N(valid, scene, &packet, IntersectArguments(options).get());         \
  }                                                                                    \
  inline void occluded_packet(const int* valid, RTCScene scene, RTCRayHit##N& packet,  \
                              const QueryOptions& options = {}) {                      \
    rtcOccluded##N(valid, scene, &packet.ray, OccludedArguments(options).get());       \
  }

#else

/// The context of one query: the application's with what the query brings, or a plain one.
class ContextOf {
 public:
  explicit ContextOf(const QueryOptions& options)
      : context_(options.context == nullptr ? &plain_ : options.context) {
    context_->filter = options.filter;
    context_->flags =
        options.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  }
  RTCIntersectContext* get() { return context_; }

 private:
  RTCIntersectContext plain_ = new_context();
  RTCIntersectContext* context_;
};

inline void intersect_one(RTCScene scene, RTCRayHit& ray, const QueryOptions& options = {}) {
  rtcIntersect1(scene, ContextOf(options).get(), &ray);
}
inline void occluded_one(RTCScene scene, RTCRay& ray, const QueryOptions& options = {}) {
  rtcOccluded1(scene, ContextOf(options).get(), &ray);
}
inline bool brings_nothing(const QueryOptions& options) {
  return options.context == nullptr && options.filter == nullptr;
}
inline void intersect_one(StbvhGeometry geometry, RTCRayHit& ray, const QueryOptions& options = {}) {
  stbvhIntersect1(geometry, brings_nothing(options) ? nullptr : ContextOf(options).get(), &ray);
}
inline void occluded_one(StbvhGeometry geometry, RTCRay& ray, const QueryOptions& options = {}) {
  stbvhOccluded1(geometry, brings_nothing(options) ? nullptr : ContextOf(options).get(), &ray);
}
inline void intersect_many(StbvhGeometry geometry, RTCRayHit* rays, std::size_t count, std::size_t stride,
                           const QueryOptions& options = {}) {
  stbvhIntersectN(geometry, brings_nothing(options) ? nullptr : ContextOf(options).get(), rays, count,
                  stride);
}
inline void occluded_many(StbvhGeometry geometry, RTCRay* rays, std::size_t count, std::size_t stride,
                          const QueryOptions& options = {}) {
  stbvhOccludedN(geometry, brings_nothing(options) ? nullptr : ContextOf(options).get(), rays, count, stride);
}

#define STBVH_TEST_PACKETS(N)                                                          \
  inline void intersect_packet(const int* valid, RTCScene scene, RTCRayHit##N& packet, \
                               const QueryOptions& options = {}) {                     \
    rtcIntersect##N(valid, scene, ContextOf(options).get(), &packet);                  \
  }                                                                                    \
  inline void occluded_packet(const int* valid, RTCScene scene, RTCRayHit##N& packet,  \
                              const QueryOptions& options = {}) {                      \
    rtcOccluded##N(valid, scene, ContextOf(options).get(), &packet.ray);               \
  }

#endif

STBVH_TEST_PACKETS(4)
STBVH_TEST_PACKETS(8)
STBVH_TEST_PACKETS(16)
#undef STBVH_TEST_PACKETS

}  // namespace stbvh::test
