// A triangle that moves in two segments, above one at rest: the kernels alone, without Embree.
#include <stbvh/structure.h>

#include <cstdint>
#include <cstdio>
#include <exception>
#include <limits>
#include <memory>
#include <vector>

namespace {

const std::uint32_t kIndices[3] = {0, 1, 2};
const stbvh::Vec3f kMoving[3][3] = {{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}},  // at time 0
                                    {{2, -1, 0}, {4, -1, 0}, {3, 1, 0}},   // at time 0.5
                                    {{2, 5, 0}, {4, 5, 0}, {3, 7, 0}}};    // at time 1
const stbvh::Vec3f kGround[3] = {{-9, -9, -1}, {9, -9, -1}, {0, 9, -1}};

/// One triangle; the structure reads indices and vertices where they are, also while rays are traced.
stbvh::MeshView triangle(const std::vector<stbvh::VertexBufferView>& steps, std::uint32_t geom_id) {
  stbvh::MeshView mesh;
  mesh.indices = kIndices;
  mesh.triangle_count = 1;
  mesh.steps = steps;
  mesh.geom_id = geom_id;
  return mesh;
}

/// Traces a ray down from z = 5; false if it does not meet mesh `expected` (kInvalidId: none).
bool trace(const stbvh::Structure& structure, float x, float y, float time, std::uint32_t expected) {
  const stbvh::Ray ray{.origin = {x, y, 5},
                       .tnear = 0,
                       .direction = {0, 0, -1},
                       .time = time,
                       .tfar = std::numeric_limits<float>::infinity(),
                       .mask = 0xFFFFFFFFu};
  stbvh::Hit hit;
  const bool found = structure.intersect(ray, hit);
  std::printf("time %.2f at (%g, %g): ", time, x, y);
  if (found) {
    std::printf("mesh %u, triangle %u, distance %g\n", hit.geom_id, hit.prim_id, hit.t);
  } else {
    std::puts("nothing");
  }
  return (found ? hit.geom_id : stbvh::kInvalidId) == expected && structure.occluded(ray) == found;
}

}  // namespace

int main() try {
  std::vector<stbvh::VertexBufferView> moving, ground{{kGround, 3}};
  for (const auto& step : kMoving) moving.push_back({step, 3});
  const stbvh::MeshView meshes[] = {triangle(moving, 0), triangle(ground, 1)};
  const std::unique_ptr<stbvh::Structure> structure = stbvh::Structure::build(meshes);
  bool right = trace(*structure, 0, 0, 0, 0);
  right &= trace(*structure, 0, 0, 0.5f, 1);
  right &= trace(*structure, 1.5f, 0, 0.25f, 0);
  right &= trace(*structure, 3, 6, 1, 0);
  right &= trace(*structure, 30, 0, 1, stbvh::kInvalidId);
  return right ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
