/// `separate-N`: the shutter in N windows, and a tree without motion for the centre of each, which answers
/// the rays of its window: "combining separate renderings" of the paper's survey.
///
/// Stored: N structures of the kernels, each over the scene as it stands at its time; a mesh that is not
/// there then is left out. Built: one after the other. Traversed: by the kernels; the time of a ray chooses
/// the structure.
///
/// Departs: a renderer of frames holds one of the trees at a time. Here all are there, so that the rays of
/// any times may be traced in any order; `bytes` are those of all. Building does not count the time that it
/// takes to find where the vertices are.
///
/// Not exact: a ray sees the scene up to half a window earlier or later.
#include <array>
#include <cmath>

#include "harness/scenes/frozen_scene.h"
#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/scene_views.h"
#include "harness/structures/build_meter.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/one_by_one.h"

namespace stbvh::harness::gallery {
namespace {

class SeparateTrees final : public OneByOne<SeparateTrees> {
 public:
  SeparateTrees(const Scene& scene, std::size_t count, unsigned threads, const BuildProgress& progress)
      : windows_(count) {
    const BuildMeter meter(threads);
    for (std::size_t i = 0; i < count; ++i) {
      const BuildProgress of_window = [&](double fraction) {
        return !progress || progress((static_cast<double>(i) + fraction) / static_cast<double>(count));
      };
      build(scene, i, of_window);
    }
    record_.steps_kept = scene.step_count();
    record_.resident_bytes = meter.resident_growth();
  }

  const BuildRecord& build_record() const override { return record_; }
  bool intersect_one(const Ray& ray, Hit& hit) const override {
    const Window* const window = window_of(ray.time);
    return window != nullptr && window->tree->intersect(ray, hit) && window->name_mesh(hit);
  }
  bool occluded_one(const Ray& ray) const override {
    const Window* const window = window_of(ray.time);
    return window != nullptr && window->tree->occluded(ray);
  }
  bool has_counters() const override { return true; }
  bool intersect_one_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const override {
    const Window* const window = window_of(ray.time);
    return window != nullptr && window->tree->intersect_counted(ray, hit, counters) && window->name_mesh(hit);
  }

 private:
  struct Window {
    std::unique_ptr<Structure> tree;
    std::vector<std::uint32_t> meshes;  ///< of the scene, which are there

    bool name_mesh(Hit& hit) const {
      hit.geom_id = hit.mesh = meshes[hit.mesh];
      return true;
    }
  };

  /// Null: outside the shutter, where nothing is.
  const Window* window_of(float time) const {
    if (!(time >= 0.0f && time <= 1.0f)) return nullptr;
    const auto window = static_cast<std::size_t>(time * static_cast<float>(windows_.size()));
    return &windows_[std::min(window, windows_.size() - 1)];
  }

  void build(const Scene& scene, std::size_t number, const BuildProgress& progress) {
    Window& window = windows_[number];
    const float centre = (static_cast<float>(number) + 0.5f) / static_cast<float>(windows_.size());
    for (std::uint32_t i = 0; i < scene.meshes.size(); ++i) {
      if (is_visible_at(scene.meshes[i], centre)) window.meshes.push_back(i);
    }
    const Scene still = frozen(scene, centre);
    const SceneViews views(still);
    const BuildMeter meter(0);
    // All leaves are inline: the buffers need not stay.
    window.tree = Structure::build(
        views.meshes(), {}, {.allocate = {}, .release = {}, .temporary_memory = {}, .progress = progress});
    const BuildStatistics& built = window.tree->statistics();
    record_.build_s += meter.seconds();
    record_.peak_bytes = std::max(record_.peak_bytes, record_.structure_bytes + built.peak_bytes);
    record_.structure_bytes += built.structure_bytes + window.meshes.size() * sizeof(std::uint32_t);
    record_.peak_bytes = std::max(record_.peak_bytes, record_.structure_bytes);
  }

  std::vector<Window> windows_;
  BuildRecord record_;
};

}  // namespace

template <std::size_t kWindows>
StructurePtr build_separate(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return std::make_unique<SeparateTrees>(scene, kWindows, threads, progress);
}

template StructurePtr build_separate<2>(const Scene&, unsigned, const BuildProgress&);
template StructurePtr build_separate<4>(const Scene&, unsigned, const BuildProgress&);
template StructurePtr build_separate<8>(const Scene&, unsigned, const BuildProgress&);
template StructurePtr build_separate<16>(const Scene&, unsigned, const BuildProgress&);
template StructurePtr build_separate<32>(const Scene&, unsigned, const BuildProgress&);

}  // namespace stbvh::harness::gallery
