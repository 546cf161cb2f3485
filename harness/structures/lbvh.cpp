#include "harness/structures/lbvh.h"

#include <algorithm>

#include "harness/structures/build_meter.h"
#include "harness/structures/embree_rays.h"
#include "harness/structures/embree_structure.h"

namespace stbvh::harness {
namespace {

float fraction(std::size_t i, std::size_t n) {
  return static_cast<float>(static_cast<double>(i) / static_cast<double>(n));
}

}  // namespace

TimeRange segment_time_range(const Mesh& mesh, std::size_t segment) {
  const std::size_t n = mesh.segment_count();
  const TimeRange all = mesh.time_range;
  const auto begin_of = [&](std::size_t k) {
    if (k == 0) return all.begin;
    if (k == n) return all.end;
    const double f = static_cast<double>(k) / static_cast<double>(n);
    return static_cast<float>(all.begin + (static_cast<double>(all.end) - all.begin) * f);
  };
  return {begin_of(segment), begin_of(segment + 1)};
}

TimeWindows::TimeWindows(const Scene& scene) {
  std::size_t windows = 0;
  for (const Mesh& mesh : scene.meshes) windows = std::max(windows, mesh.segment_count());
  if (windows == 0) return;
  for (std::size_t i = 0; i <= windows; ++i) begins_.push_back(fraction(i, windows));
  segments_.resize(windows);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    if (!scene.meshes[i].is_static() && scene.meshes[i].triangle_count() > 0) add_mesh(scene.meshes[i], i);
  }
}

void TimeWindows::add_mesh(const Mesh& mesh, std::size_t index) {
  for (std::size_t k = 0; k < mesh.segment_count(); ++k) {
    const TimeRange range = segment_time_range(mesh, k);
    if (range.begin >= 1 || range.end <= 0) continue;  // no ray is there, and Embree would abort the process
    const bool is_last = k + 1 == mesh.segment_count();
    for (std::size_t i = 0; i < count(); ++i) {
      // The mesh's own last moment belongs to its last segment, every other border to the later one.
      const bool begins_before_end = range.begin < begins_[i + 1] || i + 1 == count();
      const bool ends_after_begin = is_last ? range.end >= begins_[i] : range.end > begins_[i];
      if (begins_before_end && ends_after_begin) segments_[i].push_back({index, k});
    }
  }
}

Lbvh::Lbvh(const Scene& scene, std::string_view device_options, unsigned threads,
           const BuildProgress& progress)
    : device_(device_options, threads), times_(scene) {
  const BuildMeter meter(threads);
  build_static(scene, progress);
  build_windows(scene, progress);
  device_.check();
  record_.build_s = meter.seconds();
  record_.steps_kept = scene.step_count();
  record_.structure_bytes = record_.monitor_bytes = device_.memory().current_bytes();
  record_.peak_bytes = device_.memory().peak_bytes();
  record_.resident_bytes = meter.resident_growth();
}

BuildProgress Lbvh::part_of(const BuildProgress& progress, std::size_t part) const {
  if (!progress) return {};
  const auto parts = static_cast<double>(times_.count() + 1);
  return [&progress, parts, first = static_cast<double>(part)](double fraction) {
    return progress((first + fraction) / parts);
  };
}

void Lbvh::build_static(const Scene& scene, const BuildProgress& progress) {
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (!mesh.is_static() || mesh.triangle_count() == 0) continue;
    if (!static_scene_) static_scene_ = device_.new_scene(RTC_SCENE_FLAG_NONE);
    const GeometryPtr geometry = new_triangle_geometry(device_, mesh, 0, 1, mesh.time_range);
    rtcAttachGeometryByID(static_scene_.get(), geometry.get(), static_cast<unsigned>(i));
  }
  if (static_scene_) commit_scene(device_, static_scene_.get(), part_of(progress, 0));
}

void Lbvh::build_windows(const Scene& scene, const BuildProgress& progress) {
  std::vector<std::vector<GeometryPtr>> geometries(scene.meshes.size());  // shared by the windows
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) geometries[i].resize(scene.meshes[i].segment_count());
  for (std::size_t w = 0; w < times_.count(); ++w) {
    Window window{device_.new_scene(RTC_SCENE_FLAG_NONE), {}};
    for (const MeshSegment& s : times_.segments(w)) {
      const Mesh& mesh = scene.meshes[s.mesh];
      GeometryPtr& geometry = geometries[s.mesh][s.segment];
      if (!geometry) {
        geometry = new_triangle_geometry(device_, mesh, s.segment, 2, segment_time_range(mesh, s.segment));
      }
      rtcAttachGeometryByID(window.scene.get(), geometry.get(),
                            static_cast<unsigned>(window.mesh_of_geometry.size()));
      window.mesh_of_geometry.push_back(static_cast<std::uint32_t>(s.mesh));
    }
    commit_scene(device_, window.scene.get(), part_of(progress, w + 1));
    windows_.push_back(std::move(window));
  }
}

void Lbvh::intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  plugin::RayQuery embree;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    RTCRayHit query = to_embree_query(rays[i]);
    if (static_scene_) embree.intersect(static_scene_.get(), query);
    if (!windows_.empty()) {
      const Window& window = windows_[times_.window_of(rays[i].time)];
      const unsigned static_geometry = query.hit.geomID;
      query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      embree.intersect(window.scene.get(), query);
      query.hit.geomID = query.hit.geomID == RTC_INVALID_GEOMETRY_ID
                             ? static_geometry
                             : window.mesh_of_geometry[query.hit.geomID];
    }
    hits[i] = to_hit_record(query);
  }
}

void Lbvh::occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  plugin::RayQuery embree;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    RTCRay ray = to_embree(rays[i]);
    if (static_scene_) embree.occluded(static_scene_.get(), ray);
    if (ray.tfar >= 0.0f && !windows_.empty()) {
      const Window& window = windows_[times_.window_of(rays[i].time)];
      embree.occluded(window.scene.get(), ray);
    }
    hits[i] = to_occlusion_record(ray.tfar);
  }
}

bool Lbvh::intersect_one(const Ray& ray, Hit& hit) const {
  bool is_hit = static_scene_ && intersect_scene(static_scene_.get(), ray, hit);
  if (windows_.empty()) return is_hit;
  Ray rest = ray;
  if (is_hit) rest.tfar = hit.t;
  const Window& window = windows_[times_.window_of(ray.time)];
  Hit moving;
  if (!intersect_scene(window.scene.get(), rest, moving)) return is_hit;
  hit = moving;
  hit.geom_id = hit.mesh = window.mesh_of_geometry[moving.geom_id];
  return true;
}

bool Lbvh::occluded_one(const Ray& ray) const {
  if (static_scene_ && occluded_scene(static_scene_.get(), ray)) return true;
  return !windows_.empty() && occluded_scene(windows_[times_.window_of(ray.time)].scene.get(), ray);
}

}  // namespace stbvh::harness
