/// A scene in Embree's own triangle geometry, for pictures.
#pragma once

#include <embree3/rtcore.h>

#include "harness/scenes/scene.h"
#include "harness/structures/embree_device.h"

namespace stbvh::harness::picture {

/// The meshes of a scene on a device of its own, committed; geomIDs are mesh indices. The scene must outlive
/// it. Throws std::invalid_argument for a mesh that Embree cannot hold, std::runtime_error (std::bad_alloc
/// for want of memory) when Embree fails.
class EmbreeScene {
 public:
  explicit EmbreeScene(const Scene& scene);

  /// Closest hit; the ray's geomID says whether there is one.
  RTCRayHit intersect(Vec3f origin, Vec3f direction, float time) const;
  /// Whether anything is in the way within `distance` (in lengths of `direction`).
  bool occluded(Vec3f origin, Vec3f direction, float distance, float time) const;

 private:
  EmbreeDevice device_;
  ScenePtr scene_;
};

}  // namespace stbvh::harness::picture
