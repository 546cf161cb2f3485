#include "plugin/callbacks.h"

#include <limits>

#include "plugin/filters.h"

namespace stbvh::plugin {
namespace {

inline Ray load_ray(RTCRayN* rays, unsigned size, unsigned i) {
  Ray ray;
  ray.origin = {RTCRayN_org_x(rays, size, i), RTCRayN_org_y(rays, size, i), RTCRayN_org_z(rays, size, i)};
  ray.tnear = RTCRayN_tnear(rays, size, i);
  ray.direction = {RTCRayN_dir_x(rays, size, i), RTCRayN_dir_y(rays, size, i), RTCRayN_dir_z(rays, size, i)};
  ray.tfar = RTCRayN_tfar(rays, size, i);
  ray.time = RTCRayN_time(rays, size, i);
  ray.mask = RTCRayN_mask(rays, size, i);
  return ray;
}

inline void intersect_lane(const Lane& lane) {
  const Ray ray = load_ray(lane.rays, lane.size, lane.index);
  if (lane.published->has_intersect_filters || lane.context->filter != nullptr) {
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
  const Ray ray = load_ray(lane.rays, lane.size, lane.index);
  const bool filtered = lane.published->has_occluded_filters || lane.context->filter != nullptr;
  const bool occluded = filtered ? occluded_filtered(lane, ray) : lane.published->structure->occluded(ray);
  if (occluded) {
    RTCRayN_tfar(lane.rays, lane.size, lane.index) = -std::numeric_limits<float>::infinity();
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
  RTCRayN* const rays = RTCRayHitN_RayN(arguments->rayhit, arguments->N);
  if (arguments->N == 1) {  // most rays: offsets known when this is compiled
    if (arguments->valid[0] != 0) {
      intersect_lane({published, arguments->context, rays, 1, 0, arguments->geomID});
    }
    return;
  }
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) continue;
    intersect_lane({published, arguments->context, rays, arguments->N, i, arguments->geomID});
  }
}

void occluded_callback(const RTCOccludedFunctionNArguments* arguments) {
  const auto* const published = static_cast<const Published*>(arguments->geometryUserPtr);
  if (published->structure == nullptr) return;
  if (arguments->N == 1) {
    if (arguments->valid[0] != 0) {
      occluded_lane({published, arguments->context, arguments->ray, 1, 0, arguments->geomID});
    }
    return;
  }
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) continue;
    occluded_lane({published, arguments->context, arguments->ray, arguments->N, i, arguments->geomID});
  }
}

}  // namespace stbvh::plugin
