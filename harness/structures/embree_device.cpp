#include "harness/structures/embree_device.h"

#include <fmt/format.h>

#include <new>
#include <stdexcept>

namespace stbvh::harness {

EmbreeDevice::EmbreeDevice(std::string_view options, unsigned threads) {
  // No set_affinity: Embree would pin the calling thread too, and the harness pins its own threads.
  const std::string config =
      threads > 0 ? fmt::format("threads={},{}", threads, options) : std::string(options);
  device_ = rtcNewDevice(config.c_str());
  if (device_ == nullptr) {
    const RTCError error = rtcGetDeviceError(nullptr);
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    throw std::runtime_error(
        fmt::format("Embree cannot make a device with \"{}\" (error {}).", config, static_cast<int>(error)));
  }
  rtcSetDeviceErrorFunction(
      device_,
      [](void* user, RTCError, const char* text) { static_cast<EmbreeDevice*>(user)->last_error_ = text; },
      this);
  rtcSetDeviceMemoryMonitorFunction(
      device_,
      [](void* user, ssize_t bytes, bool) {
        static_cast<EmbreeDevice*>(user)->memory_.report(bytes);
        return true;
      },
      this);
}

EmbreeDevice::~EmbreeDevice() {
  rtcReleaseDevice(device_);
}

ScenePtr EmbreeDevice::new_scene(RTCSceneFlags flags) const {
  ScenePtr scene(rtcNewScene(device_));
  check();
  rtcSetSceneFlags(scene.get(), flags);
  return scene;
}

void EmbreeDevice::check() const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error == RTC_ERROR_NONE) return;
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error == RTC_ERROR_CANCELLED) throw BuildCancelled();
  throw std::runtime_error(fmt::format("Embree reports error {}: {}.", static_cast<int>(error), last_error_));
}

bool report_progress(void* progress, double fraction) {
  return (*static_cast<const BuildProgress*>(progress))(fraction);
}

void commit_scene(const EmbreeDevice& device, RTCScene scene, const BuildProgress& progress) {
  if (progress) {
    rtcSetSceneProgressMonitorFunction(scene, report_progress, const_cast<BuildProgress*>(&progress));
  }
  rtcCommitScene(scene);
  rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  device.check();
}

GeometryPtr new_triangle_geometry(const EmbreeDevice& device, const Mesh& mesh, std::size_t first_step,
                                  std::size_t step_count, TimeRange time_range) {
  GeometryPtr geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  device.check();
  rtcSetGeometryTimeStepCount(geometry.get(), static_cast<unsigned>(step_count));
  rtcSetGeometryTimeRange(geometry.get(), time_range.begin, time_range.end);
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(),
                             0, 3 * sizeof(std::uint32_t), mesh.triangle_count());
  for (std::size_t k = 0; k < step_count; ++k) {
    const VertexBuffer& step = mesh.steps[first_step + k];
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, static_cast<unsigned>(k),
                               RTC_FORMAT_FLOAT3, step.data(), 0, sizeof(Vec3f), step.size());
  }
  rtcSetGeometryMask(geometry.get(), mesh.mask);
  rtcCommitGeometry(geometry.get());
  device.check();
  return geometry;
}

ScenePtr new_triangle_scene(const EmbreeDevice& device, const Scene& scene, RTCSceneFlags flags,
                            const BuildProgress& progress) {
  ScenePtr result = device.new_scene(flags);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (mesh.triangle_count() == 0) continue;
    const GeometryPtr geometry = new_triangle_geometry(device, mesh, 0, mesh.steps.size(), mesh.time_range);
    rtcAttachGeometryByID(result.get(), geometry.get(), static_cast<unsigned>(i));
  }
  commit_scene(device, result.get(), progress);
  return result;
}

}  // namespace stbvh::harness
