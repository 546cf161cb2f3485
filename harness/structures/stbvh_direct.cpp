#include "harness/structures/stbvh_direct.h"

#include <algorithm>

#include "harness/scenes/scene_views.h"
#include "harness/structures/build_meter.h"
#include "stbvh/saved_structure.h"

namespace stbvh::harness {

namespace {

/// The structure that the scene came with, if it is still that of its meshes; or null.
std::unique_ptr<Structure> saved_structure(const Scene& scene, const SceneViews& views) {
  if (scene.saved == nullptr) return nullptr;
  try {
    return scene.saved->structure(views.meshes());
  } catch (const BadStructureFile&) {
    return nullptr;
  }
}

}  // namespace

StbvhDirect::StbvhDirect(const Scene& scene, const BuildSettings& settings, unsigned threads,
                         const BuildProgress& progress, std::optional<Isa> isa)
    : isa_(isa) {
  const BuildMeter meter(threads);
  const SceneViews views(scene);
  BuildSettings of_scene = settings;
  of_scene.tolerance = scene.tolerance;
  of_scene.max_bytes = std::min(settings.max_bytes, scene.max_bytes.value_or(kNoLimit));
  const auto build = [&] {
    structure_ =
        Structure::build(views.meshes(), of_scene,
                         {.allocate = {}, .release = {}, .temporary_memory = {}, .progress = progress});
  };
  try {
    if (settings == BuildSettings{}) structure_ = saved_structure(scene, views);
    if (structure_ == nullptr) build();
  } catch (const MemoryLimit& limit) {
    if (settings.max_bytes != kSmallest) throw OverLimit(limit.what());
    of_scene.max_bytes = limit.needed_bytes;
    build();
  }
  record_.build_s = meter.seconds();
  record_.structure_bytes = structure_->statistics().structure_bytes;
  record_.wanted_bytes = structure_->statistics().wanted_bytes;
  record_.peak_bytes = structure_->statistics().peak_bytes;
  record_.steps_kept = structure_->statistics().steps_kept;
  record_.max_deviation = structure_->statistics().max_deviation;
  record_.resident_bytes = meter.resident_growth();
}

void StbvhDirect::intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Hit hit;
    const bool is_hit =
        isa_ ? structure_->intersect_on(*isa_, rays[i], hit) : structure_->intersect(rays[i], hit);
    hits[i] =
        is_hit ? HitRecord{hit.t, hit.geom_id, hit.prim_id} : HitRecord{rays[i].tfar, kInvalidId, kInvalidId};
  }
}

void StbvhDirect::occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool is_hit = isa_ ? structure_->occluded_on(*isa_, rays[i]) : structure_->occluded(rays[i]);
    const std::uint32_t id = is_hit ? 0u : kInvalidId;
    hits[i] = {rays[i].tfar, id, id};
  }
}

namespace {

/// Rays side by side, and a record for each.
struct SideBySide {
  const Ray* rays;
  HitRecord* hits;

  HitRecord& of(const Ray& ray) const { return hits[&ray - rays]; }
};

RayBatch batch_of(std::span<const Ray> rays, SideBySide& both,
                  void (*report)(void* user, const Ray& ray, const Hit& hit)) {
  for (std::size_t i = 0; i < rays.size(); ++i) both.hits[i] = {rays[i].tfar, kInvalidId, kInvalidId};
  return {rays.data(), sizeof(Ray), rays.size(), report, &both};
}

}  // namespace

void StbvhBatch::intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  SideBySide both{rays.data(), hits.data()};
  tree()->intersect(batch_of(rays, both, [](void* user, const Ray& ray, const Hit& hit) {
    static_cast<const SideBySide*>(user)->of(ray) = {hit.t, hit.geom_id, hit.prim_id};
  }));
}

void StbvhBatch::occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const {
  SideBySide both{rays.data(), hits.data()};
  tree()->occluded(batch_of(rays, both, [](void* user, const Ray& ray, const Hit&) {
    static_cast<const SideBySide*>(user)->of(ray) = {ray.tfar, 0u, 0u};
  }));
}

bool StbvhDirect::intersect_one(const Ray& ray, Hit& hit) const {
  return isa_ ? structure_->intersect_on(*isa_, ray, hit) : structure_->intersect(ray, hit);
}

bool StbvhDirect::occluded_one(const Ray& ray) const {
  return isa_ ? structure_->occluded_on(*isa_, ray) : structure_->occluded(ray);
}

bool StbvhDirect::intersect_one_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
  return has_counters() ? structure_->intersect_counted(ray, hit, counters) : intersect_one(ray, hit);
}

namespace {

class OutlineCollector final : public NodeVisitor {
 public:
  OutlineCollector(float time, std::size_t level) : time_(time), level_(level) {}

  bool enter(const TreeNode& node) override {
    if (!(time_ >= node.time_range.begin && time_ <= node.time_range.end)) return false;
    if (node.level < level_ && !is_leaf(node.kind)) return true;
    outlines_.push_back(corners_of(node.box.at(time_)));
    return false;
  }
  std::vector<Outline> take() { return std::move(outlines_); }

 private:
  float time_;
  std::size_t level_;
  std::vector<Outline> outlines_;
};

}  // namespace

std::vector<Outline> StbvhDirect::outlines_at(float time, std::size_t level) const {
  OutlineCollector collector(time, level);
  structure_->visit_nodes(collector);
  return collector.take();
}

}  // namespace stbvh::harness
