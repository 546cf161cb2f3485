/// Embree's filter functions between the kernels and the application.
#pragma once

#include "plugin/embree_api.h"
#include "plugin/published.h"

namespace stbvh::plugin {

/// Embree calls user geometries with at most this many rays.
constexpr unsigned kMaxPacket = 16;

/// The rays of one call, in the application's memory: a packet of them, or rays on their own, which the
/// kernels then read where they stand.
struct Packet {
  const Published* published;
  QueryContext* context;
  QueryFilter query_filter;
  unsigned geom_id;         ///< under which the geometry is attached
  RTCRayN* rays = nullptr;  ///< of a packet, with its hits behind if it has any
  unsigned size = 1;
  const Ray* copies = nullptr;  ///< of the packet's valid lanes, as the kernels take them; null: on their own
  const unsigned* indices = nullptr;  ///< which lanes those are
};

/// One ray of them.
struct Lane {
  const Packet& packet;
  RTCRayN* rays;
  unsigned index;

  unsigned size() const { return packet.size; }
  RTCHitN* hits() const { return RTCRayHitN_HitN(reinterpret_cast<RTCRayHitN*>(rays), size()); }
  float& tfar() const { return RTCRayN_tfar(rays, size(), index); }
};

/// `ray` as the kernels were given it.
inline Lane lane_of(const Packet& packet, const Ray& ray) {
  if (packet.copies == nullptr) return {packet, reinterpret_cast<RTCRayN*>(const_cast<Ray*>(&ray)), 0};
  return {packet, packet.rays, packet.indices[&ray - packet.copies]};
}

/// HitFilter::accept with the packet as its user: the meshes' filters and the query's. An accepted closest
/// hit is written to its lane.
bool accept_closest_hit(void* packet, const Ray& ray, const Hit& candidate);
bool accept_any_hit(void* packet, const Ray& ray, const Hit& candidate);

/// Whether the query's filter may have to run.
inline bool has_query_filter(const Packet& packet) {
  return packet.query_filter.function != nullptr &&
         (packet.query_filter.on_all_meshes || packet.published->meshes_take_query_filters);
}

inline unsigned geom_id_of(const Packet& packet, const Hit& hit) {
  const unsigned own = packet.published->meshes[hit.mesh].geom_id;
  return own == RTC_INVALID_GEOMETRY_ID ? packet.geom_id : own;
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
