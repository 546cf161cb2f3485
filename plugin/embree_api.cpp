#include "plugin/embree_api.h"

#if RTC_VERSION_MAJOR >= 4

#include <memory>
#include <new>
#include <type_traits>

namespace stbvh::plugin {
namespace {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
template <typename Handle>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

/// What the callbacks of the trial are to find, and whether they did; the user data of its geometry.
struct Trial {
  const void* options;
  bool was_found;
};

/// Compares addresses alone: what is read may be anything.
template <typename Options, typename Arguments>
void look_for_options(const Arguments* arguments) {
  Trial& trial = *static_cast<Trial*>(arguments->geometryUserPtr);
  trial.was_found = &options_behind<Options>(arguments) == trial.options;
}

/// Queries a scene of one box, alone and in a packet, for both kinds of callbacks. Throws std::bad_alloc
/// where Embree makes no such scene.
bool try_options_behind_arguments() {
  const Owned<RTCDevice> device(rtcNewDevice("threads=1"));
  const Owned<RTCScene> scene(device ? rtcNewScene(device.get()) : nullptr);
  const Owned<RTCGeometry> geometry(scene ? rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER) : nullptr);
  if (!geometry) throw std::bad_alloc();
  Trial trial{nullptr, false};
  rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
  rtcSetGeometryUserData(geometry.get(), &trial);
  rtcSetGeometryBoundsFunction(
      geometry.get(),
      [](const RTCBoundsFunctionArguments* arguments) {
        *arguments->bounds_o = RTCBounds{-1, -1, -1, 0, 1, 1, 1, 0};
      },
      nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), look_for_options<IntersectOptions>);
  rtcSetGeometryOccludedFunction(geometry.get(), look_for_options<OccludedOptions>);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene.get(), geometry.get());
  rtcCommitScene(scene.get());
  if (rtcGetDeviceError(device.get()) != RTC_ERROR_NONE) throw std::bad_alloc();

  IntersectOptions intersect;
  rtcInitIntersectArguments(&intersect);
  OccludedOptions occluded;
  rtcInitOccludedArguments(&occluded);
  const auto finds = [&trial](const void* options, auto&& query) {
    trial = {options, false};
    query();
    return trial.was_found;
  };
  RTCRayHit one{};
  one.ray.org_z = -2;
  one.ray.dir_z = 1;
  one.ray.tfar = 4;
  one.ray.mask = ~0u;
  one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCRayHit4 four{};
  for (int i = 0; i < 4; ++i) {
    four.ray.org_z[i] = -2;
    four.ray.dir_z[i] = 1;
    four.ray.tfar[i] = 4;
    four.ray.mask[i] = ~0u;
    four.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  alignas(16) const int valid[4] = {-1, -1, -1, -1};
  return finds(&intersect, [&] { rtcIntersect1(scene.get(), &one, &intersect); }) &&
         finds(&occluded, [&] { rtcOccluded1(scene.get(), &one.ray, &occluded); }) &&
         finds(&intersect, [&] { rtcIntersect4(valid, scene.get(), &four, &intersect); }) &&
         finds(&occluded, [&] { rtcOccluded4(valid, scene.get(), &four.ray, &occluded); });
}

}  // namespace

bool keeps_options_behind_arguments() {
  static const bool keeps = try_options_behind_arguments();
  return keeps;
}

}  // namespace stbvh::plugin

#endif
