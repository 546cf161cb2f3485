/// Finds out by a query whether Embree 4 keeps a query's options where embree_api.h looks for them.
#pragma once

#include <memory>
#include <new>
#include <type_traits>

#include "plugin/embree_api.h"

#if RTC_VERSION_MAJOR >= 4

namespace stbvh::plugin {

/// What the callbacks of the trial are to find, and whether they did; the user data of its geometry.
struct OptionsTrial {
  const void* options;
  bool was_found;

  /// A callback. Compares addresses alone: what is read may be anything.
  template <typename Options, typename Arguments>
  static void look_for_options(const Arguments* arguments) {
    OptionsTrial& trial = *static_cast<OptionsTrial*>(arguments->geometryUserPtr);
    trial.was_found = &options_behind<Options>(arguments) == trial.options;
  }
};

/// Queries a scene of one box, alone and in a packet, for both kinds of callbacks. `kEmbree` as for
/// UserGeometry. Throws std::bad_alloc where Embree makes no such scene.
template <auto kEmbree>
bool finds_options_behind_arguments(RTCDevice device) {
  const auto& embree = kEmbree();
  const auto release_scene = [&](RTCScene scene) { embree.rtcReleaseScene(scene); };
  const auto release_geometry = [&](RTCGeometry geometry) { embree.rtcReleaseGeometry(geometry); };
  using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(release_scene)>;
  using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, decltype(release_geometry)>;
  const Scene scene(embree.rtcNewScene(device), release_scene);
  if (!scene) throw std::bad_alloc();
  const Geometry geometry(embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER), release_geometry);
  if (!geometry) throw std::bad_alloc();
  OptionsTrial trial{nullptr, false};
  embree.rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
  embree.rtcSetGeometryUserData(geometry.get(), &trial);
  embree.rtcSetGeometryBoundsFunction(
      geometry.get(),
      [](const RTCBoundsFunctionArguments* arguments) {
        *arguments->bounds_o = RTCBounds{-1, -1, -1, 0, 1, 1, 1, 0};
      },
      nullptr);
  embree.rtcSetGeometryIntersectFunction(geometry.get(), OptionsTrial::look_for_options<IntersectOptions>);
  embree.rtcSetGeometryOccludedFunction(geometry.get(), OptionsTrial::look_for_options<OccludedOptions>);
  embree.rtcCommitGeometry(geometry.get());
  embree.rtcAttachGeometry(scene.get(), geometry.get());
  embree.rtcCommitScene(scene.get());
  if (embree.rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::bad_alloc();

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
  return finds(&intersect, [&] { embree.rtcIntersect1(scene.get(), &one, &intersect); }) &&
         finds(&occluded, [&] { embree.rtcOccluded1(scene.get(), &one.ray, &occluded); }) &&
         finds(&intersect, [&] { embree.rtcIntersect4(valid, scene.get(), &four, &intersect); }) &&
         finds(&occluded, [&] { embree.rtcOccluded4(valid, scene.get(), &four.ray, &occluded); });
}

}  // namespace stbvh::plugin

#endif
