/// One triangle primitive of a glTF file, and where its vertices are in a pose.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "harness/scenes/gltf/pose.h"
#include "harness/scenes/gltf/transform.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::gltf {

/// The joints of a skin: node and inverse bind matrix of each.
struct Skin {
  std::vector<std::size_t> nodes;
  std::vector<Affine> inverse_bind;
};

/// How many joints move each vertex, and how much; the weights of a vertex sum to 1.
struct Influences {
  std::size_t per_vertex = 0;
  std::vector<std::uint32_t> joints;
  std::vector<double> weights;
};

struct Primitive {
  std::size_t node = 0;                      ///< that carries it
  std::vector<std::uint32_t> indices;        ///< 3 for each triangle, all below vertex_count()
  std::vector<double> positions;             ///< x, y, z of each vertex before morphing
  std::vector<std::vector<double>> targets;  ///< offsets of each morph target; empty: it moves nothing
  std::optional<Skin> skin;                  ///< if there is one, the node's own transform is ignored
  Influences influences;

  std::size_t vertex_count() const { return positions.size() / 3; }
};

/// Triangles, strips and fans. Nothing for points, lines, and where there is no position or no triangle.
/// Throws Problem.
std::optional<Primitive> read_primitive(const tinygltf::Model& model, std::size_t node,
                                        const tinygltf::Primitive& source);

/// World-space positions: morphed, then skinned or moved with the node. In double, rounded once.
VertexBuffer deform(const Primitive& primitive, const Pose& pose);

/// One vertex of deform().
Vec3f deform_vertex(const Primitive& primitive, const Pose& pose, std::size_t vertex);

}  // namespace stbvh::harness::gltf
