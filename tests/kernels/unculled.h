/// The triangle test of the kernels with nothing above it: neither boxes nor splits in time.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "kernels/builder/build_context.h"
#include "kernels/builder/mesh_parts.h"
#include "kernels/isolated.h"
#include "limited.h"
#include "off_plane.h"
#include "test_meshes.h"

namespace stbvh::test {

/// One structure for each triangle whose root is a leaf, so that nothing is culled: what this accepts, a tree
/// over the same triangles must find. All triangles must be valid.
///
/// A tree over one triangle that moves fast is split in time, and those nodes have boxes; so is one over a
/// thin triangle at rest, if rounding makes its boxes a little larger. So each structure is built over a
/// triangle of size 1 that is at rest, with an indexed leaf, which reads the caller's vertices when it is
/// asked: after building, they are replaced by the moving ones.
class Unculled {
 public:
  explicit Unculled(std::span<const MeshView> meshes) {
    for (const MeshView& mesh : meshes) add(mesh);
  }
  Unculled(const Unculled&) = delete;
  Unculled& operator=(const Unculled&) = delete;

  /// `off` becomes what off_plane() says of the hit that lies farthest off.
  std::optional<Hit> intersect(Isa isa, Ray ray, double* off = nullptr) const {
    std::optional<Hit> nearest;
    for (const Triangle& triangle : triangles_) {
      Hit hit;
      if (!triangle.leaf->intersect_on(isa, ray, hit)) continue;
      if (off != nullptr)
        *off = std::max(*off, triangle.off_plane_of(context_.meshes[triangle.mesh], ray, hit.t));
      if (nearest && hit.t == nearest->t) continue;
      nearest = hit;
      nearest->prim_id = triangle.prim;
      ray.tfar = hit.t;
    }
    return nearest;
  }

 private:
  using Corners = std::array<Vec3f, 3>;

  struct Triangle {
    std::unique_ptr<Structure> leaf;
    std::uint32_t prim;
    std::vector<Corners> steps;  ///< read by `leaf`
    std::size_t mesh;

    double off_plane_of(const BuildMesh& of, const Ray& ray, float t) const {
      if (steps.size() == 1) return off_plane(steps[0], steps[0], 0.0f, ray, t);
      const SegmentTime at = of.segment_at(ray.time);
      return off_plane(steps[at.segment], steps[at.segment + 1], at.fraction, ray, t);
    }
  };

  static Corners corners(const VertexBufferView& step, const std::array<std::uint32_t, 3>& vertices) {
    Corners p;
    for (std::size_t i = 0; i < 3; ++i) {
      std::memcpy(&p[i], static_cast<const char*>(step.data) + vertices[i] * step.stride, sizeof p[i]);
    }
    return p;
  }

  /// In the parts, and with the steps, that a structure keeps by default.
  void add(const MeshView& given) {
    const std::size_t first = context_.meshes.size();
    // Where a build does it: tasks have the flush-to-zero mode of the program's first, not that of this
    // thread.
    isolated([&] { add_mesh(context_, given, 0); });
    for (std::size_t i = first; i < context_.meshes.size(); ++i) add_triangles(i);
  }

  void add_triangles(std::size_t built) {
    const BuildMesh& whole_or_part = context_.meshes[built];
    const MeshView& mesh = whole_or_part.view();
    std::size_t bytes = 0;  // of any triangle at rest
    static constexpr std::array<std::uint32_t, 3> kOwnVertices{0, 1, 2};
    constexpr Corners kAtRest{Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0}};
    for (std::size_t i = 0; i < whole_or_part.triangle_count(); ++i) {
      const std::uint32_t prim = whole_or_part.prim(i);
      std::array<std::uint32_t, 3> vertices;
      std::memcpy(&vertices, static_cast<const char*>(mesh.indices) + prim * mesh.index_stride,
                  sizeof vertices);
      std::vector<Corners> corners_of_steps(mesh.steps.size(), kAtRest);
      std::vector<VertexBufferView> steps;
      for (const Corners& step : corners_of_steps) steps.push_back({step.data(), 3, sizeof(Vec3f)});
      MeshView one = mesh;
      one.indices = kOwnVertices.data();
      one.triangle_count = 1;
      one.steps = steps;
      // They begin to move when their buffers are filled.
      BuildSettings indexed{.tolerance = kKeepAllSteps};
      if (bytes == 0) bytes = smallest_bytes({&one, 1}, indexed);
      indexed.max_bytes = bytes;
      auto leaf = Structure::build({&one, 1}, indexed);
      if (leaf->statistics().triangles == 0) continue;  // a mesh that is never alive
      if (leaf->statistics().depth != 0) throw std::logic_error("a triangle at rest is more than a leaf");
      for (std::size_t k = 0; k < steps.size(); ++k) corners_of_steps[k] = corners(mesh.steps[k], vertices);
      triangles_.push_back({std::move(leaf), prim, std::move(corners_of_steps), built});
    }
  }

  BuildCallbacks no_callbacks_;
  BuildContext context_{{}, no_callbacks_};
  std::vector<Triangle> triangles_;
};

}  // namespace stbvh::test
