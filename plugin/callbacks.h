/// The callbacks that Embree calls for a user geometry whose user data is a Published.
#pragma once

#include <embree3/rtcore.h>

namespace stbvh::plugin {

void bounds_callback(const RTCBoundsFunctionArguments* arguments);
void intersect_callback(const RTCIntersectFunctionNArguments* arguments);
void occluded_callback(const RTCOccludedFunctionNArguments* arguments);

}  // namespace stbvh::plugin
