/// The harness's rays and hits in Embree's form. One source for every structure that Embree traces, so that
/// none pays more for it than another.
#pragma once

#include "harness/structures/hit_record.h"
#include "plugin/embree_api.h"

namespace stbvh::harness {

inline RTCRay to_embree(const Ray& ray) {
  RTCRay r;
  r.org_x = ray.origin.x;
  r.org_y = ray.origin.y;
  r.org_z = ray.origin.z;
  r.tnear = ray.tnear;
  r.dir_x = ray.direction.x;
  r.dir_y = ray.direction.y;
  r.dir_z = ray.direction.z;
  r.time = ray.time;
  r.tfar = ray.tfar;
  r.mask = ray.mask;
  r.id = 0;
  r.flags = 0;
  return r;
}

/// A query ready for rtcIntersect1, without a hit yet.
inline RTCRayHit to_embree_query(const Ray& ray) {
  RTCRayHit query;
  query.ray = to_embree(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.primID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

inline HitRecord to_hit_record(const RTCRayHit& query) {
  return {query.ray.tfar, query.hit.geomID, query.hit.primID};
}

/// All that is known of a hit; the mesh `geom_id` was hit.
inline Hit to_hit(const RTCRayHit& query, std::uint32_t geom_id) {
  return {.t = query.ray.tfar,
          .u = query.hit.u,
          .v = query.hit.v,
          .normal = {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z},
          .prim_id = query.hit.primID,
          .geom_id = geom_id,
          .mesh = geom_id};
}

/// Answer to an occlusion query: Embree sets tfar to -inf where something is in the way.
inline HitRecord to_occlusion_record(const RTCRay& ray) {
  return {ray.tfar, ray.tfar < 0.0f ? 0u : kInvalidId, ray.tfar < 0.0f ? 0u : kInvalidId};
}

}  // namespace stbvh::harness
