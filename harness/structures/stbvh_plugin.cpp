#include "harness/structures/stbvh_plugin.h"

#include <fmt/format.h>

#include <new>
#include <stdexcept>
#include <string>

#include "harness/structures/build_meter.h"
#include "harness/structures/embree_structure.h"

namespace stbvh::harness {

StbvhPlugin::StbvhPlugin(const Scene& scene, const PluginSettings& settings, unsigned threads,
                         const BuildProgress& progress)
    : indices_(scene.meshes.size(), kNotAdded), device_("", threads) {
  const BuildMeter meter(threads);
  geometry_.reset(stbvhNewGeometry(device_.get()));
  if (!geometry_) throw std::bad_alloc();
  scene_ = device_.new_scene(RTC_SCENE_FLAG_NONE);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (mesh.triangle_count() == 0) continue;
    const bool stays_embrees = settings.still_in_embree && mesh.is_static();
    stays_embrees ? attach_mesh(mesh, static_cast<unsigned>(i)) : set_mesh(mesh, static_cast<unsigned>(i));
  }
  check(stbvhSetGeometryPrecision(geometry_.get(), settings.precision));
  check(stbvhSetGeometryTolerance(geometry_.get(), scene.tolerance));
  if (progress) {
    check(stbvhSetGeometryProgressFunction(geometry_.get(), report_progress,
                                           const_cast<BuildProgress*>(&progress)));
  }
  check(stbvhSetGeometryMaxBytes(geometry_.get(), scene.max_bytes.value_or(STBVH_NO_LIMIT), STBVH_NO_LIMIT));
  const RTCError built = stbvhCommitGeometry(geometry_.get());
  const std::string message = stbvhGetErrorMessage(geometry_.get());
  if (built == RTC_ERROR_OUT_OF_MEMORY && message.find("limit") != std::string::npos)
    throw OverLimit(message);
  check(built);
  check(stbvhSetGeometryProgressFunction(geometry_.get(), nullptr, nullptr));
  rtcAttachGeometryByID(scene_.get(), stbvhGetGeometry(geometry_.get()),
                        static_cast<unsigned>(scene.meshes.size()));
  rtcCommitScene(scene_.get());
  device_.check();
  record_.build_s = meter.seconds();
  StbvhStatistics statistics;
  stbvhInitStatistics(&statistics);
  check(stbvhGetStatistics(geometry_.get(), &statistics));
  record_.monitor_bytes = device_.memory().current_bytes();
  record_.structure_bytes = settings.still_in_embree ? record_.monitor_bytes : statistics.structureBytes;
  record_.wanted_bytes = statistics.wantedBytes;
  record_.peak_bytes = device_.memory().peak_bytes();
  record_.steps_kept = settings.still_in_embree
                           ? scene.step_count() - statistics.stepsGiven + statistics.stepsKept
                           : statistics.stepsKept;
  record_.max_deviation = statistics.maxDeviation;
  record_.resident_bytes = meter.resident_growth();
}

void StbvhPlugin::update(const Scene& scene, std::span<const MeshEdit> edits) {
  for (const auto& [index, extent] : edits) {
    if (extent != MeshEdit::Extent::kPositions)  // those are found out by the commit
      set_mesh(scene.meshes[index], static_cast<unsigned>(index));
  }
  check(stbvhCommitGeometry(geometry_.get()));
  rtcCommitScene(scene_.get());
  device_.check();
}

/// Adds it, or replaces it.
void StbvhPlugin::set_mesh(const Mesh& mesh, unsigned geom_id) {
  std::vector<const void*> vertices;
  for (const VertexBuffer& step : mesh.steps) vertices.push_back(step.data());
  StbvhMeshArguments arguments;
  stbvhInitMeshArguments(&arguments);
  arguments.indices = mesh.indices.data();
  arguments.triangleCount = mesh.triangle_count();
  arguments.vertices = vertices.data();
  arguments.vertexCount = mesh.steps.front().size();
  arguments.stepCount = static_cast<unsigned>(mesh.steps.size());
  arguments.startTime = mesh.time_range.begin;
  arguments.endTime = mesh.time_range.end;
  arguments.stepTimes = mesh.has_step_times() ? mesh.step_times.data() : nullptr;
  arguments.mask = mesh.mask;
  arguments.geomID = geom_id;
  unsigned& index = indices_[geom_id];
  check(index == kNotAdded ? stbvhAddMesh(geometry_.get(), &arguments, &index)
                           : stbvhSetMesh(geometry_.get(), index, &arguments));
}

/// As Embree's own triangles.
void StbvhPlugin::attach_mesh(const Mesh& mesh, unsigned geom_id) {
  const GeometryPtr geometry = new_triangle_geometry(device_, mesh, 0, 1, mesh.time_range);
  rtcAttachGeometryByID(scene_.get(), geometry.get(), geom_id);
}

void StbvhPlugin::check(RTCError error) const {
  if (error == RTC_ERROR_NONE) return;
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error == RTC_ERROR_CANCELLED) throw BuildCancelled();
  throw std::runtime_error(fmt::format("The plugin reports error {}: {}", static_cast<int>(error),
                                       stbvhGetErrorMessage(geometry_.get())));
}

void StbvhPlugin::intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  intersect_scene(scene_.get(), rays, hits);
}

void StbvhPlugin::occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  occluded_scene(scene_.get(), rays, hits);
}

bool StbvhPlugin::intersect_one(const Ray& ray, Hit& hit) const {
  return intersect_scene(scene_.get(), ray, hit);
}

bool StbvhPlugin::occluded_one(const Ray& ray) const {
  return occluded_scene(scene_.get(), ray);
}

}  // namespace stbvh::harness
