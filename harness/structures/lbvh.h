/// Linear-motion BVHs, one for each global time segment, as renderers had before the STBVH (Embree 2.12).
///
/// Embree 3 has no such tree; this one is made of its scenes with linear motion, on the meshes' own buffers,
/// exact for step counts that do not divide each other.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "harness/structures/embree_device.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// Segment `segment` of the mesh `mesh` of a scene.
struct MeshSegment {
  std::size_t mesh;
  std::size_t segment;
};

/// Which window of global time a ray falls into, and which segments a window holds.
///
/// Windows and segments begin at floats, each the nearest to its rational number: where two begin at the same
/// rational time they begin at the same float, so no ray falls between.
class TimeWindows {
 public:
  explicit TimeWindows(const Scene& scene);

  /// Most segments of any mesh; 0 if all are static.
  std::size_t count() const { return begins_.empty() ? 0 : begins_.size() - 1; }

  /// The window [begin, end) that holds `time` in [0, 1]; the last one holds 1 too.
  std::size_t window_of(float time) const {
    const std::size_t last = count() - 1;
    const auto guess = static_cast<std::size_t>(time * static_cast<float>(count()));
    std::size_t i = guess < last ? guess : last;
    if (time < begins_[i]) --i;
    if (i < last && time >= begins_[i + 1]) ++i;
    return i;
  }

  /// Every segment of every moving mesh that some time of the window falls into.
  const std::vector<MeshSegment>& segments(std::size_t window) const { return segments_[window]; }

 private:
  void add_mesh(const Mesh& mesh, std::size_t index);

  std::vector<float> begins_;  ///< of each window, and the end of the last
  std::vector<std::vector<MeshSegment>> segments_;
};

/// Time range of one segment of a moving mesh, in global time.
TimeRange segment_time_range(const Mesh& mesh, std::size_t segment);

class Lbvh final : public StructureUnderTest {
 public:
  Lbvh(const Scene& scene, std::string_view device_options, unsigned threads, const BuildProgress& progress);

  const BuildRecord& build_record() const override { return record_; }
  void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const override;
  bool intersect_one(const Ray& ray, Hit& hit) const override;
  bool occluded_one(const Ray& ray) const override;

 private:
  struct Window {
    ScenePtr scene;
    std::vector<std::uint32_t> mesh_of_geometry;
  };

  /// `progress` of the scene of what stands still (part 0), or of a window.
  BuildProgress part_of(const BuildProgress& progress, std::size_t part) const;
  void build_static(const Scene& scene, const BuildProgress& progress);
  void build_windows(const Scene& scene, const BuildProgress& progress);

  EmbreeDevice device_;
  TimeWindows times_;
  ScenePtr static_scene_;  ///< null if every mesh moves
  std::vector<Window> windows_;
  BuildRecord record_;
};

}  // namespace stbvh::harness
