/// Embree's filter functions between the kernels and the application.
#pragma once

#include "plugin/embree_api.h"
#include "plugin/published.h"

namespace stbvh::plugin {

/// One lane of a packet in the application's memory; N = 1 is a packet of one.
struct Lane {
  const Published* published;
  QueryContext* context;
  QueryFilter query_filter;
  RTCRayN* rays;
  unsigned size;
  unsigned index;
  unsigned geom_id;  ///< under which the geometry is attached
};

/// Closest hit with the meshes' intersection filters and the query's; writes hit and tfar to the lane.
void intersect_filtered(const Lane& lane, const Ray& ray);

/// Any hit with the meshes' occlusion filters and the query's; the caller then sets the lane's tfar.
bool occluded_filtered(const Lane& lane, const Ray& ray);

/// Whether the query's filter may have to run.
inline bool has_query_filter(const Lane& lane) {
  return lane.query_filter.function != nullptr &&
         (lane.query_filter.on_all_meshes || lane.published->meshes_take_query_filters);
}

inline unsigned geom_id_of(const Lane& lane, const Hit& hit) {
  const unsigned own = lane.published->meshes[hit.mesh].geom_id;
  return own == RTC_INVALID_GEOMETRY_ID ? lane.geom_id : own;
}

/// Writes hit data to entry `index` of a packet of `size`.
inline void store_hit(RTCHitN* hits, unsigned size, unsigned index, const Hit& hit, unsigned geom_id,
                      const QueryContext* context) {
  RTCHitN_Ng_x(hits, size, index) = hit.normal.x;
  RTCHitN_Ng_y(hits, size, index) = hit.normal.y;
  RTCHitN_Ng_z(hits, size, index) = hit.normal.z;
  RTCHitN_u(hits, size, index) = hit.u;
  RTCHitN_v(hits, size, index) = hit.v;
  RTCHitN_primID(hits, size, index) = hit.prim_id;
  RTCHitN_geomID(hits, size, index) = geom_id;
  for (unsigned level = 0; level < RTC_MAX_INSTANCE_LEVEL_COUNT; ++level) {
    RTCHitN_instID(hits, size, index, level) = context->instID[level];
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
    RTCHitN_instPrimID(hits, size, index, level) = context->instPrimID[level];
#endif
  }
}

}  // namespace stbvh::plugin
