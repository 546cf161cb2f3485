/// The harness's rays and hits in Embree's form. One source for every structure that Embree traces, so that
/// none pays more for it than another.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

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
inline HitRecord to_occlusion_record(float tfar) {
  return {tfar, tfar < 0.0f ? 0u : kInvalidId, tfar < 0.0f ? 0u : kInvalidId};
}

inline constexpr std::size_t kPacket = 16;

/// The first rays of `first` as a packet of 16. Lanes without one are switched off twice: Embree 3 does not
/// look at `valid` where it cuts packets up.
template <typename Rays>
struct EmbreePacket {
  alignas(64) int valid[kPacket];
  Rays rays;
  std::size_t count;

  explicit EmbreePacket(std::span<const Ray> first) : count(std::min(first.size(), kPacket)) {
    RTCRay16& r = lanes(rays);
    for (std::size_t i = 0; i < kPacket; ++i) {
      const Ray& ray = first[i < count ? i : 0];
      valid[i] = i < count ? -1 : 0;
      r.org_x[i] = ray.origin.x;
      r.org_y[i] = ray.origin.y;
      r.org_z[i] = ray.origin.z;
      r.tnear[i] = i < count ? ray.tnear : 1.0f;
      r.dir_x[i] = ray.direction.x;
      r.dir_y[i] = ray.direction.y;
      r.dir_z[i] = ray.direction.z;
      r.time[i] = ray.time;
      r.tfar[i] = i < count ? ray.tfar : -1.0f;
      r.mask[i] = ray.mask;
      r.id[i] = 0;
      r.flags[i] = 0;
    }
  }

  void clear_hits() {
    std::ranges::fill(rays.hit.geomID, RTC_INVALID_GEOMETRY_ID);
    std::ranges::fill(rays.hit.primID, RTC_INVALID_GEOMETRY_ID);
    std::ranges::fill(rays.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
  }

  HitRecord hit_record(std::size_t i) const {
    return {rays.ray.tfar[i], rays.hit.geomID[i], rays.hit.primID[i]};
  }

 private:
  static RTCRay16& lanes(RTCRay16& rays) { return rays; }
  static RTCRay16& lanes(RTCRayHit16& rays) { return rays.ray; }
};

}  // namespace stbvh::harness
