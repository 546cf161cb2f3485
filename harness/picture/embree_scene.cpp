#include "harness/picture/embree_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "harness/structures/embree_rays.h"

namespace stbvh::harness::picture {
namespace {

Ray make_ray(Vec3f origin, Vec3f direction, float distance, float time) {
  return {.origin = origin,
          .tnear = 0.0f,
          .direction = direction,
          .time = time,
          .tfar = distance,
          .mask = 0xFFFFFFFFu};
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

/// Checked before Embree sees any of it.
const Scene& checked(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) check_mesh(mesh);
  return scene;
}

}  // namespace

EmbreeScene::EmbreeScene(const Scene& scene)
    : device_("", 0), scene_(new_triangle_scene(device_, checked(scene), RTC_SCENE_FLAG_NONE)) {}

RTCRayHit EmbreeScene::intersect(Vec3f origin, Vec3f direction, float time) const {
  RTCIntersectContext context = new_context();
  RTCRayHit query =
      to_embree_query(make_ray(origin, direction, std::numeric_limits<float>::infinity(), time));
  rtcIntersect1(scene_.get(), &context, &query);
  return query;
}

bool EmbreeScene::occluded(Vec3f origin, Vec3f direction, float distance, float time) const {
  RTCIntersectContext context = new_context();
  RTCRay ray = to_embree(make_ray(origin, direction, distance, time));
  rtcOccluded1(scene_.get(), &context, &ray);
  return to_occlusion_record(ray).is_hit();
}

}  // namespace stbvh::harness::picture
