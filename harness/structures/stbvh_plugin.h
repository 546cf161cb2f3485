/// Our structure as an application uses it: the plugin's user geometry, attached to a scene of Embree.
#pragma once

#include <stbvh/stbvh_embree.h>

#include <memory>
#include <type_traits>
#include <vector>

#include "harness/structures/embree_device.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// How the plugin is asked to build; the defaults are its own.
struct PluginSettings {
  StbvhPrecision precision = STBVH_PRECISION_WATERTIGHT;
  bool still_in_embree = false;  ///< meshes of one step stay Embree's own, beside ours in one scene
};

class StbvhPlugin : public StructureUnderTest {
 public:
  StbvhPlugin(const Scene& scene, const PluginSettings& settings, unsigned threads,
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
  struct Release {
    void operator()(StbvhGeometry geometry) const { stbvhReleaseGeometry(geometry); }
  };
  using StbvhGeometryPtr = std::unique_ptr<std::remove_pointer_t<StbvhGeometry>, Release>;

  void set_mesh(const Mesh& mesh, unsigned geom_id);
  void attach_mesh(const Mesh& mesh, unsigned geom_id);
  void check(RTCError error) const;

  static constexpr unsigned kNotAdded = 0xFFFFFFFFu;

  std::vector<unsigned> indices_;  ///< in the plugin, of each mesh of the scene
  EmbreeDevice device_;
  StbvhGeometryPtr geometry_;
  ScenePtr scene_;
  BuildRecord record_;
};

}  // namespace stbvh::harness
