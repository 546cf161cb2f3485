/// Rays that every structure under test is asked with, and what it answered.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "stbvh/structure.h"

namespace stbvh::harness {

enum class RayKind { kPrimary, kBounce, kUniform, kShadow, kBounceOccluded, kUniformOccluded };

std::string_view ray_kind_name(RayKind kind);

/// Rays of one kind. Shadow rays and the two occluded kinds are traced with occluded, the others with
/// intersect.
struct RaySet {
  RayKind kind = RayKind::kPrimary;
  std::vector<Ray> rays;

  bool any_hit() const {
    return kind == RayKind::kShadow || kind == RayKind::kBounceOccluded || kind == RayKind::kUniformOccluded;
  }
};

/// Answer to one ray; `geom_id` is the index of the mesh in the scene, kInvalidId for a miss.
/// For occlusion rays only hit or miss is known: geom_id is 0 or kInvalidId.
struct HitRecord {
  float t;
  std::uint32_t geom_id;
  std::uint32_t prim_id;

  bool is_hit() const { return geom_id != kInvalidId; }
};

}  // namespace stbvh::harness
