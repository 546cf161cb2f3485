/// What a structure answers to a ray.
#pragma once

#include <cstdint>

#include "stbvh/structure.h"

namespace stbvh::harness {

/// Answer to one ray; `geom_id` is the index of the mesh in the scene, kInvalidId for a miss.
/// For occlusion rays only hit or miss is known: geom_id is 0 or kInvalidId.
struct HitRecord {
  float t;
  std::uint32_t geom_id;
  std::uint32_t prim_id;

  bool is_hit() const { return geom_id != kInvalidId; }
};

}  // namespace stbvh::harness
