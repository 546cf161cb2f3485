/// The one place that knows which Embree this is, 3.13 or 4: the C header includes one of them.
#pragma once

#include "stbvh/stbvh_embree.h"

namespace stbvh::plugin {

/// A filter that a ray's query brings with it, besides those of the meshes.
struct QueryFilter {
  RTCFilterFunctionN function = nullptr;
  bool on_all_meshes = true;  ///< else only on those that ask for it
};

/// Whether an Embree lays out queries as this library takes them: a program may run with another Embree than
/// the one whose headers this was compiled with.
struct EmbreeLayout {
  bool options_behind_arguments = false;  ///< where options_behind looks for them
  bool hits = false;                      ///< else nothing may be written to them
};

#if RTC_VERSION_MAJOR >= 4

using QueryContext = RTCRayQueryContext;
using IntersectOptions = RTCIntersectArguments;
using OccludedOptions = RTCOccludedArguments;

/// Of scenes whose rays may bring filters with them.
constexpr RTCSceneFlags kSceneTakesQueryFilters = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

inline QueryContext new_context() {
  QueryContext context;
  rtcInitRayQueryContext(&context);
  return context;
}

/// Of the Embree in this process, found out by queries, once. Throws std::bad_alloc where there is no memory
/// for it.
EmbreeLayout embree_layout();

/// Of a query's options, which may be null: `plain` where they bring no context.
template <typename Options>
QueryContext* context_of(const Options* options, QueryContext& plain) {
  return options == nullptr || options->context == nullptr ? &plain : options->context;
}

template <typename Options>
QueryFilter filter_of(const Options* options) {
  if (options == nullptr) return {};
  return {options->filter, (options->flags & RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER) != 0};
}

/// What the arguments of a user geometry's callback are the beginning of.
template <typename Arguments, typename Options>
struct ArgumentsWithOptions {
  Arguments arguments;
  const void* geometry;
  const void* forward_scene;
  const Options* options;
};

/// The options of the query that a callback of a user geometry works for. Nothing public leads to them:
/// Embree calls the filters of geometries alone on what user geometries find.
template <typename Options, typename Arguments>
const Options& options_behind(const Arguments* arguments) {
  return *reinterpret_cast<const ArgumentsWithOptions<Arguments, Options>*>(arguments)->options;
}

inline QueryFilter filter_of_query(const RTCIntersectFunctionNArguments* arguments) {
  return filter_of(&options_behind<IntersectOptions>(arguments));
}
inline QueryFilter filter_of_query(const RTCOccludedFunctionNArguments* arguments) {
  return filter_of(&options_behind<OccludedOptions>(arguments));
}

/// Rays asked one by one or in packets of 16, without filters of their own.
class RayQuery {
 public:
  void intersect(RTCScene scene, RTCRayHit& rayhit) { rtcIntersect1(scene, &rayhit, nullptr); }
  void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, nullptr); }
  void intersect(RTCScene scene, const int* valid, RTCRayHit16& rayhits) {
    rtcIntersect16(valid, scene, &rayhits, nullptr);
  }
  void occluded(RTCScene scene, const int* valid, RTCRay16& rays) {
    rtcOccluded16(valid, scene, &rays, nullptr);
  }
};

#else

using QueryContext = RTCIntersectContext;

constexpr RTCSceneFlags kSceneTakesQueryFilters = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

inline QueryContext new_context() {
  QueryContext context;
  rtcInitIntersectContext(&context);
  return context;
}

inline EmbreeLayout embree_layout() {
  return {true, true};
}

/// A query's options are its context, which may be null.
inline QueryContext* context_of(QueryContext* options, QueryContext& plain) {
  return options == nullptr ? &plain : options;
}

inline QueryFilter filter_of(const QueryContext* options) {
  if (options == nullptr) return {};
  return {options->filter};
}

template <typename Arguments>
QueryFilter filter_of_query(const Arguments* arguments) {
  return filter_of(arguments->context);
}

class RayQuery {
 public:
  void intersect(RTCScene scene, RTCRayHit& rayhit) { rtcIntersect1(scene, &context_, &rayhit); }
  void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &context_, &ray); }
  void intersect(RTCScene scene, const int* valid, RTCRayHit16& rayhits) {
    rtcIntersect16(valid, scene, &context_, &rayhits);
  }
  void occluded(RTCScene scene, const int* valid, RTCRay16& rays) {
    rtcOccluded16(valid, scene, &context_, &rays);
  }

 private:
  RTCIntersectContext context_ = new_context();
};

#endif

}  // namespace stbvh::plugin
