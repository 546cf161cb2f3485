/// The callbacks that Embree calls for a user geometry whose user data is a Published, and what they do for
/// rays without Embree.
#pragma once

#include <cstddef>

#include "plugin/embree_api.h"
#include "plugin/published.h"

namespace stbvh::plugin {

void bounds_callback(const RTCBoundsFunctionArguments* arguments);
void intersect_callback(const RTCIntersectFunctionNArguments* arguments);
void occluded_callback(const RTCOccludedFunctionNArguments* arguments);

/// Rays of the application, `stride` bytes apart.
template <typename Ray>
struct Rays {
  Ray* first;
  std::size_t count = 1;
  std::size_t stride = sizeof(Ray);
};

/// `published` must have a structure; `geom_id` is that of its mesh without one of its own.
void intersect(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
               Rays<RTCRayHit> rays);
void occluded(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
              Rays<RTCRay> rays);

}  // namespace stbvh::plugin
