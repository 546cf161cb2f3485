/// The Embree that this library is linked with.
#pragma once

#include "plugin/embree_api.h"

namespace stbvh::plugin {

/// The functions of the Embree that this library is linked with, for UserGeometry and try_layout.
struct LinkedEmbree {
  static constexpr auto rtcNewGeometry = ::rtcNewGeometry;
  static constexpr auto rtcReleaseGeometry = ::rtcReleaseGeometry;
  static constexpr auto rtcCommitGeometry = ::rtcCommitGeometry;
  static constexpr auto rtcSetGeometryUserPrimitiveCount = ::rtcSetGeometryUserPrimitiveCount;
  static constexpr auto rtcSetGeometryUserData = ::rtcSetGeometryUserData;
  static constexpr auto rtcSetGeometryBoundsFunction = ::rtcSetGeometryBoundsFunction;
  static constexpr auto rtcSetGeometryIntersectFunction = ::rtcSetGeometryIntersectFunction;
  static constexpr auto rtcSetGeometryOccludedFunction = ::rtcSetGeometryOccludedFunction;
  static constexpr auto rtcSetGeometryTimeStepCount = ::rtcSetGeometryTimeStepCount;
  static constexpr auto rtcSetGeometryTimeRange = ::rtcSetGeometryTimeRange;
  static constexpr auto rtcSetGeometryMask = ::rtcSetGeometryMask;
  static constexpr auto rtcSetSharedGeometryBuffer = ::rtcSetSharedGeometryBuffer;
  static constexpr auto rtcNewScene = ::rtcNewScene;
  static constexpr auto rtcReleaseScene = ::rtcReleaseScene;
  static constexpr auto rtcAttachGeometry = ::rtcAttachGeometry;
  static constexpr auto rtcCommitScene = ::rtcCommitScene;
  static constexpr auto rtcGetDeviceError = ::rtcGetDeviceError;
  static constexpr auto rtcIntersect1 = ::rtcIntersect1;
  static constexpr auto rtcOccluded1 = ::rtcOccluded1;
  static constexpr auto rtcIntersect4 = ::rtcIntersect4;
  static constexpr auto rtcOccluded4 = ::rtcOccluded4;
};
inline LinkedEmbree linked_embree() {
  return {};
}

}  // namespace stbvh::plugin
