#include "plugin/device_error.h"

#include <new>

namespace stbvh::plugin {
namespace {

// No header of Embree 3 lists them, and both enumerations can hold them.
constexpr auto kUnlistedProperty = static_cast<RTCDeviceProperty>(255);
constexpr auto kUnlistedType = static_cast<RTCGeometryType>(127);

// Where one of these is given no memory for what it needs, that becomes the device's error.

/// An operation that user geometries do not have.
void fail_with_invalid_operation(RTCDevice device) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  if (geometry == nullptr) return;
  rtcSetGeometryTessellationRate(geometry, 1);
  rtcReleaseGeometry(geometry);
}

void* no_memory_for_leaf(RTCThreadLocalAllocator, const RTCBuildPrimitive*, std::size_t, void*) {
  throw std::bad_alloc();
}

/// A build of a tree of one leaf, on this thread alone, whose callback has no memory.
///
/// A buffer that is larger than all memory would do too, but Embree 3.13.5 then keeps a reference to the
/// device for ever, and the memory monitor is told of it.
void fail_with_out_of_memory(RTCDevice device) {
  const RTCBVH bvh = rtcNewBVH(device);
  if (bvh == nullptr) return;
  RTCBuildPrimitive primitive{};
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.bvh = bvh;
  arguments.primitives = &primitive;
  arguments.primitiveCount = arguments.primitiveArrayCapacity = 1;
  arguments.createNode = [](RTCThreadLocalAllocator, unsigned, void*) -> void* { return nullptr; };
  arguments.setNodeChildren = [](void*, void**, unsigned, void*) {};
  arguments.setNodeBounds = [](void*, const RTCBounds**, unsigned, void*) {};
  arguments.createLeaf = no_memory_for_leaf;
  rtcBuildBVH(&arguments);
  rtcReleaseBVH(bvh);
}

/// A commit of a scene whose progress function cancels it.
void fail_with_cancelled(RTCDevice device) {
  const RTCScene scene = rtcNewScene(device);
  if (scene == nullptr) return;
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  if (geometry == nullptr) return rtcReleaseScene(scene);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* arguments) { *arguments->bounds_o = {}; }, nullptr);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneProgressMonitorFunction(
      scene, [](void*, double) { return false; }, nullptr);
  rtcCommitScene(scene);
  rtcReleaseScene(scene);
}

}  // namespace

void set_device_error(RTCDevice device, RTCError code) noexcept {
  try {
    switch (code) {
      case RTC_ERROR_INVALID_ARGUMENT:
        rtcGetDeviceProperty(device, kUnlistedProperty);
        break;
      case RTC_ERROR_INVALID_OPERATION:
        fail_with_invalid_operation(device);
        break;
      case RTC_ERROR_OUT_OF_MEMORY:
        fail_with_out_of_memory(device);
        break;
      case RTC_ERROR_CANCELLED:
        fail_with_cancelled(device);
        break;
      default:
        rtcNewGeometry(device, kUnlistedType);
    }
  } catch (...) {  // Embree 3.13.5 throws where it has no memory for a thread's first error
  }
}

}  // namespace stbvh::plugin
