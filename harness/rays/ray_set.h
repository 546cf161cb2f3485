/// Rays that every structure under test is asked with.
#pragma once

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

}  // namespace stbvh::harness
