/// Embree's own motion blur tree, as an application would build it.
#pragma once

#include <string_view>

#include "harness/structures/embree_device.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// Device string with which Embree keeps the vertices of one segment in its leaves ("4v").
inline constexpr std::string_view kVertexLeaves = "tri_accel_mb=bvh8.triangle4vmb";

class EmbreeStructure : public StructureUnderTest {
 public:
  EmbreeStructure(const Scene& scene, std::string_view device_options, RTCSceneFlags flags, unsigned threads,
                  const BuildProgress& progress);

  const BuildRecord& build_record() const override { return record_; }
  void update(const Scene& scene, std::span<const MeshEdit> edits) override;
  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  bool intersect_one(const Ray& ray, Hit& hit) const override;
  bool occluded_one(const Ray& ray) const override;

 protected:
  RTCScene scene() const { return scene_.get(); }

 private:
  EmbreeDevice device_;
  ScenePtr scene_;
  BuildRecord record_;
  std::vector<bool> is_attached_;  ///< of each mesh of the scene
};

/// Traces `rays` through one Embree scene, one by one or in packets of 16; geomIDs are taken as they are.
void intersect_scene(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits);
void occluded_scene(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits);
void intersect_in_packets(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits);
void occluded_in_packets(RTCScene scene, std::span<const Ray> rays, std::span<HitRecord> hits);
bool intersect_scene(RTCScene scene, const Ray& ray, Hit& hit);
bool occluded_scene(RTCScene scene, const Ray& ray);

/// A structure of Embree's scenes, asked with packets of 16 rays; for pictures with single rays, as it is.
template <typename EmbreeScene>
class InPackets final : public EmbreeScene {
 public:
  using EmbreeScene::EmbreeScene;

  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override {
    intersect_in_packets(this->scene(), rays, hits);
  }
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override {
    occluded_in_packets(this->scene(), rays, hits);
  }
};

}  // namespace stbvh::harness
