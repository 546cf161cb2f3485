#include "harness/scenes/procedural/barbarian/body_cage.h"

#include <algorithm>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/subdivision/subdivision.h"

namespace stbvh::harness {
namespace {

constexpr unsigned kMostLevels = 2;
/// Quads below which a human figure loses its fingers and face: in pictures, 7,300 keep them, 1,800 do not.
constexpr std::size_t kFewestQuads = 4000;
/// Each takes the distance to the body down to about a third.
constexpr int kFitIterations = 4;

/// Faces without positions.
SubdivisionCage quads_of(const Shape& shape) {
  SubdivisionCage cage;
  cage.face_sizes.assign(shape.indices.size() / 6, 4);
  cage.face_vertices.reserve(4 * cage.face_sizes.size());
  for (std::size_t i = 0; i < shape.indices.size(); i += 6) {
    for (const std::size_t corner : {i, i + 1, i + 2, i + 5})
      cage.face_vertices.push_back(shape.indices[corner]);
  }
  return cage;
}

VertexBuffer to_buffer(const std::vector<Vec3>& positions) {
  VertexBuffer buffer(positions.size());
  std::transform(positions.begin(), positions.end(), buffer.data(), to_float);
  return buffer;
}

/// Moves the vertices until their limits lie on the body: a cage on the body has its surface inside.
void fit(Shape& shape, const ImplicitBody& body) {
  SubdivisionCage cage = quads_of(shape);
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    cage.steps = {to_buffer(shape.positions)};
    const Mesh limit = refine(cage, {0, {}});
    for_all(shape.positions.size(), [&](std::size_t v) {
      const Vec3 p = to_double(limit.steps[0][v]);
      shape.positions[v] = shape.positions[v] - normalize(body.gradient(p, 1e-3)) * body.distance(p);
    });
  }
}

}  // namespace

BodyCage make_body_cage(const ImplicitBody& body, const Skeleton& skeleton, std::size_t triangles) {
  BodyCage cage;
  while (cage.level < kMostLevels && triangles / 2 >> (2 * (cage.level + 1)) >= kFewestQuads) ++cage.level;
  cage.skinned = SkinnedShape::from(body, skeleton, triangles >> (2 * cage.level)).select([](Vec3) {
    return true;  // drops vertices that no triangle uses, which refine() would drop too
  });
  fit(cage.skinned.shape, body);
  return cage;
}

RefinedBody refine_body(const BodyCage& cage, const std::vector<std::vector<Rigid>>& transforms) {
  SubdivisionCage quads = quads_of(cage.skinned.shape);
  quads.steps = {to_buffer(cage.skinned.shape.positions)};
  RefinedBody result;
  result.rest = refine(quads, {cage.level, {}}).steps[0];
  quads.steps = skin("", cage.skinned, transforms, {}).steps;
  result.moving = refine(quads, {cage.level, {}});
  return result;
}

Mesh RefinedBody::select(std::string name, Vec3f color, const std::function<bool(Vec3)>& choose) const {
  constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
  std::vector<std::uint32_t> renumbered(rest.size(), kUnused), chosen;
  Mesh mesh;
  mesh.name = std::move(name);
  mesh.material.color = color;
  for (std::size_t t = 0; t < moving.indices.size(); t += 3) {
    Vec3 centroid;
    for (std::size_t k = 0; k < 3; ++k)
      centroid = centroid + to_double(rest[moving.indices[t + k]]) * (1.0 / 3);
    if (!choose(centroid)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = moving.indices[t + k];
      if (renumbered[v] == kUnused) {
        renumbered[v] = static_cast<std::uint32_t>(chosen.size());
        chosen.push_back(v);
      }
      mesh.indices.push_back(renumbered[v]);
    }
  }
  for (const VertexBuffer& step : moving.steps) {
    VertexBuffer& buffer = mesh.steps.emplace_back(chosen.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) buffer[i] = step[chosen[i]];
  }
  return mesh;
}

}  // namespace stbvh::harness
