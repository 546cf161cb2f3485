/// The callbacks that Embree calls for a user geometry whose user data is a Published, and what they do for
/// one ray without Embree.
#pragma once

#include "plugin/embree_api.h"
#include "plugin/published.h"

namespace stbvh::plugin {

void bounds_callback(const RTCBoundsFunctionArguments* arguments);
void intersect_callback(const RTCIntersectFunctionNArguments* arguments);
void occluded_callback(const RTCOccludedFunctionNArguments* arguments);

/// `published` must have a structure; `geom_id` is that of its mesh without one of its own.
void intersect_one(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
                   RTCRayHit* rayhit);
void occluded_one(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
                  RTCRay* ray);

}  // namespace stbvh::plugin
