#include "harness/structures/embree_structure.h"

#include "harness/structures/build_meter.h"
#include "harness/structures/embree_rays.h"

namespace stbvh::harness {

EmbreeStructure::EmbreeStructure(const Scene& scene, std::string_view device_options, RTCSceneFlags flags,
                                 unsigned threads, const BuildProgress& progress)
    : device_(device_options, threads) {
  const BuildMeter meter(threads);
  scene_ = new_triangle_scene(device_, scene, flags, progress);
  record_.build_s = meter.seconds();
  for (const Mesh& mesh : scene.meshes) is_attached_.push_back(mesh.triangle_count() > 0);
  record_.steps_kept = scene.step_count();
  record_.structure_bytes = record_.monitor_bytes = device_.memory().current_bytes();
  record_.peak_bytes = device_.memory().peak_bytes();
  record_.resident_bytes = meter.resident_growth();
}

void EmbreeStructure::update(const Scene& scene, std::span<const MeshEdit> edits) {
  for (const auto& [index, extent] : edits) {
    const auto id = static_cast<unsigned>(index);
    const Mesh& mesh = scene.meshes[index];
    if (extent == MeshEdit::Extent::kEverything) {
      if (is_attached_[index]) rtcDetachGeometry(scene_.get(), id);
      is_attached_[index] = mesh.triangle_count() > 0;
      if (!is_attached_[index]) continue;
      const GeometryPtr geometry =
          new_triangle_geometry(device_, mesh, 0, mesh.steps.size(), mesh.time_range);
      rtcAttachGeometryByID(scene_.get(), geometry.get(), id);
    } else if (is_attached_[index]) {
      const RTCGeometry geometry = rtcGetGeometry(scene_.get(), id);
      rtcSetGeometryMask(geometry, mesh.mask);
      for (unsigned step = 0; extent == MeshEdit::Extent::kPositions && step < mesh.steps.size(); ++step)
        rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step);
      rtcCommitGeometry(geometry);
    }
  }
  rtcCommitScene(scene_.get());
  device_.check();
}

void EmbreeStructure::intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  intersect_scene(scene_.get(), rays, hits);
}

void EmbreeStructure::occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  occluded_scene(scene_.get(), rays, hits);
}

bool EmbreeStructure::intersect_one(const Ray& ray, Hit& hit) const {
  return intersect_scene(scene_.get(), ray, hit);
}

bool EmbreeStructure::occluded_one(const Ray& ray) const {
  return occluded_scene(scene_.get(), ray);
}

void intersect_scene(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits) {
  plugin::RayQuery embree;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    RTCRayHit query = to_embree_query(rays[i]);
    embree.intersect(scene, query);
    hits[i] = to_hit_record(query);
  }
}

void occluded_scene(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits) {
  plugin::RayQuery embree;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    RTCRay ray = to_embree(rays[i]);
    embree.occluded(scene, ray);
    hits[i] = to_occlusion_record(ray.tfar);
  }
}

void intersect_in_packets(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits) {
  plugin::RayQuery embree;
  for (std::size_t begin = 0; begin < rays.size(); begin += kPacket) {
    EmbreePacket<RTCRayHit16> packet(rays.subspan(begin));
    packet.clear_hits();
    embree.intersect(scene, packet.valid, packet.rays);
    for (std::size_t i = 0; i < packet.count; ++i) hits[begin + i] = packet.hit_record(i);
  }
}

void occluded_in_packets(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits) {
  plugin::RayQuery embree;
  for (std::size_t begin = 0; begin < rays.size(); begin += kPacket) {
    EmbreePacket<RTCRay16> packet(rays.subspan(begin));
    embree.occluded(scene, packet.valid, packet.rays);
    for (std::size_t i = 0; i < packet.count; ++i) hits[begin + i] = to_occlusion_record(packet.rays.tfar[i]);
  }
}

bool intersect_scene(RTCScene scene, const Ray& ray, Hit& hit) {
  plugin::RayQuery embree;
  RTCRayHit query = to_embree_query(ray);
  embree.intersect(scene, query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit = to_hit(query, query.hit.geomID);
  return true;
}

bool occluded_scene(RTCScene scene, const Ray& ray) {
  plugin::RayQuery embree;
  RTCRay query = to_embree(ray);
  embree.occluded(scene, query);
  return to_occlusion_record(query.tfar).is_hit();
}

}  // namespace stbvh::harness
