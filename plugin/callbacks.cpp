#include "plugin/callbacks.h"

#include <cstddef>
#include <limits>

#include "plugin/filters.h"

namespace stbvh::plugin {
namespace {

static_assert(offsetof(Ray, tnear) == offsetof(RTCRay, tnear) &&
              offsetof(Ray, direction) == offsetof(RTCRay, dir_x) &&
              offsetof(Ray, time) == offsetof(RTCRay, time) &&
              offsetof(Ray, tfar) == offsetof(RTCRay, tfar) && offsetof(Ray, mask) == offsetof(RTCRay, mask));

/// A lane's ray as the kernels take it. Of a packet of one it is the application's own memory: a copy would
/// cost as much as a node.
inline const Ray& ray_of(const Lane& lane, Ray& copy) {
  if (lane.size == 1) return *reinterpret_cast<const Ray*>(lane.rays);
  RTCRayN* const rays = lane.rays;
  const unsigned size = lane.size;
  const unsigned i = lane.index;
  copy.origin = {RTCRayN_org_x(rays, size, i), RTCRayN_org_y(rays, size, i), RTCRayN_org_z(rays, size, i)};
  copy.tnear = RTCRayN_tnear(rays, size, i);
  copy.direction = {RTCRayN_dir_x(rays, size, i), RTCRayN_dir_y(rays, size, i), RTCRayN_dir_z(rays, size, i)};
  copy.time = RTCRayN_time(rays, size, i);
  copy.tfar = RTCRayN_tfar(rays, size, i);
  copy.mask = RTCRayN_mask(rays, size, i);
  return copy;
}

inline void intersect_lane(const Lane& lane) {
  Ray copy;
  const Ray& ray = ray_of(lane, copy);
  if (lane.published->has_intersect_filters || has_query_filter(lane)) {
    intersect_filtered(lane, ray);
    return;
  }
  Hit hit;
  if (!lane.published->structure->intersect(ray, hit)) return;
  RTCHitN* const hits = RTCRayHitN_HitN(reinterpret_cast<RTCRayHitN*>(lane.rays), lane.size);
  RTCRayN_tfar(lane.rays, lane.size, lane.index) = hit.t;
  store_hit(hits, lane.size, lane.index, hit, geom_id_of(lane, hit), lane.context);
}

inline void occluded_lane(const Lane& lane) {
  Ray copy;
  const Ray& ray = ray_of(lane, copy);
  const bool filtered = lane.published->has_occluded_filters || has_query_filter(lane);
  const bool occluded = filtered ? occluded_filtered(lane, ray) : lane.published->structure->occluded(ray);
  if (occluded) {
    RTCRayN_tfar(lane.rays, lane.size, lane.index) = -std::numeric_limits<float>::infinity();
  }
}

/// Calls `trace` with each valid lane of a callback's packet.
template <typename Arguments, typename Trace>
inline void for_each_lane(const Published& published, const Arguments* arguments, RTCRayN* rays,
                          Trace&& trace) {
  const QueryFilter filter = published.runs_query_filters ? filter_of_query(arguments) : QueryFilter{};
  if (arguments->N == 1) {  // most rays: offsets known when this is compiled
    if (arguments->valid[0] != 0)
      trace({&published, arguments->context, filter, rays, 1, 0, arguments->geomID});
    return;
  }
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != 0)
      trace({&published, arguments->context, filter, rays, arguments->N, i, arguments->geomID});
  }
}

}  // namespace

void bounds_callback(const RTCBoundsFunctionArguments* arguments) {
  const auto& steps = static_cast<const Published*>(arguments->geometryUserPtr)->grid.steps;
  // A scene may hold more steps than an emptied geometry has boxes: it is empty at each of them.
  const Box3f& box = arguments->timeStep < steps.size() ? steps[arguments->timeStep] : steps.back();
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = box.lower.x;
  bounds.lower_y = box.lower.y;
  bounds.lower_z = box.lower.z;
  bounds.upper_x = box.upper.x;
  bounds.upper_y = box.upper.y;
  bounds.upper_z = box.upper.z;
}

void intersect_callback(const RTCIntersectFunctionNArguments* arguments) {
  const auto* const published = static_cast<const Published*>(arguments->geometryUserPtr);
  if (published->structure == nullptr) return;
  for_each_lane(*published, arguments, RTCRayHitN_RayN(arguments->rayhit, arguments->N),
                [](const Lane& lane) { intersect_lane(lane); });
}

void occluded_callback(const RTCOccludedFunctionNArguments* arguments) {
  const auto* const published = static_cast<const Published*>(arguments->geometryUserPtr);
  if (published->structure == nullptr) return;
  for_each_lane(*published, arguments, arguments->ray, [](const Lane& lane) { occluded_lane(lane); });
}

void intersect_one(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
                   RTCRayHit* rayhit) {
  intersect_lane({&published, context, filter, reinterpret_cast<RTCRayN*>(&rayhit->ray), 1, 0, geom_id});
}

void occluded_one(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
                  RTCRay* ray) {
  occluded_lane({&published, context, filter, reinterpret_cast<RTCRayN*>(ray), 1, 0, geom_id});
}

}  // namespace stbvh::plugin
