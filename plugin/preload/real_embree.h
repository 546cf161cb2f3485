/// The Embree behind this library.
#pragma once

#include <embree3/rtcore.h>

namespace stbvh::preload {

/// Those that this library stands in front of, or calls itself.
#define STBVH_REAL_FUNCTIONS(X)                                                                              \
  X(rtcNewDevice)                                                                                            \
  X(rtcGetDeviceProperty) X(rtcGetDeviceError) X(rtcSetDeviceErrorFunction) X(                               \
      rtcSetDeviceMemoryMonitorFunction) X(rtcNewScene) X(rtcRetainScene) X(rtcReleaseScene)                 \
      X(rtcAttachGeometry) X(rtcAttachGeometryByID) X(rtcDetachGeometry) X(rtcCommitScene) X(                \
          rtcJoinCommitScene) X(rtcSetSceneProgressMonitorFunction) X(rtcSetSceneBuildQuality)               \
          X(rtcSetSceneFlags) X(rtcGetSceneFlags) X(rtcPointQuery) X(rtcPointQuery4) X(rtcPointQuery8) X(    \
              rtcPointQuery16) X(rtcCollide) X(rtcNewGeometry) X(rtcRetainGeometry) X(rtcReleaseGeometry)    \
              X(rtcCommitGeometry) X(rtcEnableGeometry) X(rtcDisableGeometry) X(rtcSetGeometryTimeStepCount) \
                  X(rtcSetGeometryTimeRange) X(rtcSetGeometryVertexAttributeCount) X(rtcSetGeometryMask) X(  \
                      rtcSetGeometryBuildQuality) X(rtcSetGeometryMaxRadiusScale) X(rtcSetGeometryBuffer)    \
                      X(rtcSetSharedGeometryBuffer) X(rtcSetNewGeometryBuffer) X(rtcGetGeometryBufferData)   \
                          X(rtcUpdateGeometryBuffer) X(rtcSetGeometryIntersectFilterFunction)                \
                              X(rtcSetGeometryOccludedFilterFunction) X(rtcSetGeometryUserData)              \
                                  X(rtcGetGeometryUserData) X(rtcSetGeometryPointQueryFunction)              \
                                      X(rtcSetGeometryUserPrimitiveCount) X(rtcSetGeometryBoundsFunction) X( \
                                          rtcSetGeometryIntersectFunction) X(rtcSetGeometryOccludedFunction) \
                                          X(rtcSetGeometryInstancedScene) X(rtcSetGeometryTransform)         \
                                              X(rtcSetGeometryTransformQuaternion)                           \
                                                  X(rtcSetGeometryTessellationRate)                          \
                                                      X(rtcSetGeometryTopologyCount)                         \
                                                          X(rtcSetGeometrySubdivisionMode)                   \
                                                              X(rtcSetGeometryVertexAttributeTopology)       \
                                                                  X(rtcSetGeometryDisplacementFunction)      \
                                                                      X(rtcGetBufferData)

struct RealEmbree {
#define STBVH_REAL_MEMBER(name) decltype(&::name) name = nullptr;
  STBVH_REAL_FUNCTIONS(STBVH_REAL_MEMBER)
#undef STBVH_REAL_MEMBER
};

/// Looks them up at the first call; without an Embree 3 in the process it says so and aborts.
const RealEmbree& real();

}  // namespace stbvh::preload
