/// One triangle primitive of a glTF file, and where its vertices are in a pose.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "harness/scenes/gltf/model.h"
#include "harness/scenes/gltf/pose.h"
#include "harness/scenes/gltf/transform.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::gltf {

/// How many joints move each vertex, and how much; the weights of a vertex sum to 1.
struct Influences {
  std::size_t per_vertex = 0;
  std::vector<std::uint32_t> used;    ///< those joints of the skin that have a weight, ascending
  std::vector<std::uint32_t> joints;  ///< places in `used`
  std::vector<double> weights;
};

/// Triangles and all that they are deformed by; the same for all nodes with the mesh.
struct Geometry {
  std::vector<std::uint32_t> indices;        ///< 3 for each triangle, all below vertex_count()
  std::vector<double> positions;             ///< x, y, z of each vertex before morphing
  std::vector<std::vector<double>> targets;  ///< offsets of each morph target; empty: it moves nothing
  Influences influences;

  std::size_t vertex_count() const { return positions.size() / 3; }
};

struct Primitive {
  std::size_t node = 0;  ///< that carries it
  std::shared_ptr<const Geometry> geometry;
  std::optional<std::size_t> skin;  ///< if there is one, the node's own transform is ignored
  Affine instance;                  ///< below the node
};

/// Triangles, strips and fans that have positions which can be read.
bool has_triangles(const Model::Primitive& source);
/// Whether joints move it where its node has a skin.
bool has_influences(const Model::Primitive& source);
/// Of those. Without what joints do to it where it is not skinned. Throws Problem.
std::shared_ptr<const Geometry> read_geometry(const Model& model, const Model::Primitive& source,
                                              bool is_skinned);

/// Throws Problem where the skin does not have as many joints as the vertices need.
void check_joints(const Geometry& geometry, const Skin& skin);

Skin read_skin(const Model& model, std::size_t index);

/// The transforms below `node` at which its mesh is instanced; one, the identity, where it is not.
std::vector<Affine> read_instances(const Model& model, std::size_t node);

/// World-space positions: morphed, then skinned or moved with the node. In double, rounded once.
VertexBuffer deform(const Primitive& primitive, const Rig& rig, const Pose& pose);

/// One vertex of deform().
Vec3f deform_vertex(const Primitive& primitive, const Rig& rig, const Pose& pose, std::size_t vertex);

}  // namespace stbvh::harness::gltf
