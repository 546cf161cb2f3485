#include "harness/picture/embree_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace stbvh::harness::picture {
namespace {

RTCRay make_ray(Vec3f origin, Vec3f direction, float distance, float time) {
  RTCRay ray{};
  ray.org_x = origin.x;
  ray.org_y = origin.y;
  ray.org_z = origin.z;
  ray.dir_x = direction.x;
  ray.dir_y = direction.y;
  ray.dir_z = direction.z;
  ray.tnear = 0.0f;
  ray.tfar = distance;
  ray.time = time;
  ray.mask = 0xFFFFFFFFu;
  return ray;
}

void check_mesh(const Mesh& mesh) {
  const auto refuse = [&mesh](const char* reason) {
    throw std::invalid_argument(fmt::format("The mesh \"{}\" cannot be shown: {}.", mesh.name, reason));
  };
  if (mesh.steps.empty()) refuse("it has no steps");
  if (mesh.steps.size() > kMaxSteps) refuse("it has too many steps");
  for (const VertexBuffer& step : mesh.steps) {
    if (step.size() != mesh.steps.front().size()) refuse("its steps have different numbers of vertices");
  }
  const TimeRange range = mesh.time_range;
  if (!(std::isfinite(range.begin) && std::isfinite(range.end) && range.begin < range.end)) {
    refuse("its time range is empty");
  }
}

}  // namespace

EmbreeScene::EmbreeScene(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) check_mesh(mesh);
  device_ = rtcNewDevice(nullptr);
  if (device_ == nullptr) throw std::runtime_error("Embree cannot make a device for pictures.");
  scene_ = rtcNewScene(device_);
  try {
    for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
      if (scene.meshes[i].triangle_count() > 0) attach(scene.meshes[i], static_cast<unsigned>(i));
    }
    rtcCommitScene(scene_);
    check_device();
  } catch (...) {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
    throw;
  }
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void EmbreeScene::attach(const Mesh& mesh, unsigned geom_id) {
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(mesh.steps.size()));
  rtcSetGeometryTimeRange(geometry, mesh.time_range.begin, mesh.time_range.end);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                             3 * sizeof(std::uint32_t), mesh.triangle_count());
  for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, static_cast<unsigned>(step),
                               RTC_FORMAT_FLOAT3, mesh.steps[step].data(), 0, sizeof(Vec3f),
                               mesh.steps[step].size());
  }
  rtcSetGeometryMask(geometry, 0xFFFFFFFFu);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_, geometry, geom_id);
  rtcReleaseGeometry(geometry);
  check_device();
}

void EmbreeScene::check_device() const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::runtime_error("Not enough memory for the picture.");
  if (error != RTC_ERROR_NONE) {
    throw std::runtime_error(
        fmt::format("Embree reports error {} for the picture.", static_cast<int>(error)));
  }
}

RTCRayHit EmbreeScene::intersect(Vec3f origin, Vec3f direction, float time) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query{};
  query.ray = make_ray(origin, direction, std::numeric_limits<float>::infinity(), time);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_, &context, &query);
  return query;
}

bool EmbreeScene::occluded(Vec3f origin, Vec3f direction, float distance, float time) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = make_ray(origin, direction, distance, time);
  rtcOccluded1(scene_, &context, &ray);
  return ray.tfar < 0.0f;
}

}  // namespace stbvh::harness::picture
