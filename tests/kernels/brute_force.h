/// The triangle test of the kernels without any box above it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "test_meshes.h"

namespace stbvh::test {

/// One structure for each triangle: its root is the leaf, so that nothing is culled. What this accepts, a
/// tree over the same triangles must find.
class BruteForce {
 public:
  explicit BruteForce(std::span<const MeshView> meshes, const BuildSettings& settings = {}) {
    for (const MeshView& mesh : meshes) {
      for (std::size_t prim = 0; prim < mesh.triangle_count; ++prim) {
        MeshView one = mesh;
        one.indices = static_cast<const char*>(mesh.indices) + prim * mesh.index_stride;
        one.triangle_count = 1;
        auto structure = Structure::build({&one, 1}, settings);
        if (structure->statistics().triangles == 1) {
          triangles_.push_back({std::move(structure), static_cast<std::uint32_t>(prim)});
        }
      }
    }
  }

  std::optional<Hit> intersect(Isa isa, Ray ray) const {
    std::optional<Hit> nearest;
    for (const Triangle& triangle : triangles_) {
      Hit hit;
      if (!triangle.structure->intersect_on(isa, ray, hit)) continue;
      hit.prim_id = triangle.prim;
      if (nearest && hit.t == nearest->t) continue;
      nearest = hit;
      ray.tfar = hit.t;
    }
    return nearest;
  }

 private:
  struct Triangle {
    std::unique_ptr<Structure> structure;
    std::uint32_t prim;
  };
  std::vector<Triangle> triangles_;
};

}  // namespace stbvh::test
