/// A scene as the kernels take it.
#pragma once

#include <span>
#include <vector>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Views of all meshes of a scene, on their own buffers; geom_id: the index.
class SceneViews {
 public:
  explicit SceneViews(const Scene& scene);
  SceneViews(const SceneViews&) = delete;
  SceneViews& operator=(const SceneViews&) = delete;

  std::span<const MeshView> meshes() const { return meshes_; }

 private:
  std::vector<std::vector<VertexBufferView>> steps_;
  std::vector<MeshView> meshes_;
};

}  // namespace stbvh::harness
