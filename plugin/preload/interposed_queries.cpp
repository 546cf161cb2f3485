/// Queries that only Embree's own triangles answer.
#include "plugin/preload/native_twin.h"
#include "plugin/preload/real_embree.h"

using stbvh::preload::real;
using stbvh::preload::scene_to_ask;

extern "C" {

bool rtcPointQuery(RTCScene scene, RTCPointQuery* query, RTCPointQueryContext* context,
                   RTCPointQueryFunction function, void* user_ptr) {
  return real().rtcPointQuery(scene_to_ask(scene), query, context, function, user_ptr);
}

bool rtcPointQuery4(const int* valid, RTCScene scene, RTCPointQuery4* query, RTCPointQueryContext* context,
                    RTCPointQueryFunction function, void** user_ptr) {
  return real().rtcPointQuery4(valid, scene_to_ask(scene), query, context, function, user_ptr);
}

bool rtcPointQuery8(const int* valid, RTCScene scene, RTCPointQuery8* query, RTCPointQueryContext* context,
                    RTCPointQueryFunction function, void** user_ptr) {
  return real().rtcPointQuery8(valid, scene_to_ask(scene), query, context, function, user_ptr);
}

bool rtcPointQuery16(const int* valid, RTCScene scene, RTCPointQuery16* query, RTCPointQueryContext* context,
                     RTCPointQueryFunction function, void** user_ptr) {
  return real().rtcPointQuery16(valid, scene_to_ask(scene), query, context, function, user_ptr);
}

void rtcCollide(RTCScene scene0, RTCScene scene1, RTCCollideFunc callback, void* user_ptr) {
  real().rtcCollide(scene_to_ask(scene0), scene_to_ask(scene1), callback, user_ptr);
}

}  // extern "C"
