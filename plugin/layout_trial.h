/// Finds out by queries whether the Embree 4 of this process lays them out as the headers here.
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

/// Queries a scene of a box and a triangle behind it, alone and in a packet, for both kinds of callbacks.
/// `kEmbree` as for UserGeometry. Throws std::bad_alloc where Embree makes no such scene.
template <auto kEmbree>
EmbreeLayout try_layout(RTCDevice device) {
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
  const Geometry triangle(embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE), release_geometry);
  if (!triangle) throw std::bad_alloc();
  static constexpr unsigned kCorners[3] = {0, 1, 2};
  static constexpr float kPositions[12] = {-9, -9, 1.5f, 9, -9, 1.5f, 0, 9, 1.5f, 0, 0, 0};  // and padding
  embree.rtcSetSharedGeometryBuffer(triangle.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, kCorners, 0,
                                    12, 1);
  embree.rtcSetSharedGeometryBuffer(triangle.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, kPositions,
                                    0, 12, 3);
  embree.rtcCommitGeometry(triangle.get());
  embree.rtcAttachGeometry(scene.get(), triangle.get());
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
  one.hit.geomID = RTC_INVALID_GEOMETRY_ID;  // and all others 0
  RTCRayHit4 four{};
  for (int i = 0; i < 4; ++i) {
    four.ray.org_z[i] = -2;
    four.ray.dir_z[i] = 1;
    four.ray.tfar[i] = 3;
    four.ray.mask[i] = ~0u;
    four.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  alignas(16) const int valid[4] = {-1, -1, -1, -1};
  EmbreeLayout found;
  found.options_behind_arguments =
      finds(&intersect, [&] { embree.rtcIntersect1(scene.get(), &one, &intersect); });
  one.ray.tfar = 3;  // the other rays end before the triangle: one that found it may not ask for the box
  found.options_behind_arguments =
      found.options_behind_arguments &&
      finds(&occluded, [&] { embree.rtcOccluded1(scene.get(), &one.ray, &occluded); }) &&
      finds(&intersect, [&] { embree.rtcIntersect4(valid, scene.get(), &four, &intersect); }) &&
      finds(&occluded, [&] { embree.rtcOccluded4(valid, scene.get(), &four.ray, &occluded); });
  found.hits = one.hit.geomID != RTC_INVALID_GEOMETRY_ID;
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  // Embree before 4.3, and one that was built without instance arrays, does not know the last member.
  found.hits = found.hits && one.hit.instPrimID[0] == RTC_INVALID_GEOMETRY_ID;
#endif
  return found;
}

}  // namespace stbvh::plugin

#endif
