/// The node tree of a glTF file and its state at one time of a clip.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <vector>

#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/transform.h"

namespace stbvh::harness::gltf {

/// Parents, and orders to walk in. The nodes are a forest, or the constructor throws Problem.
class NodeTree {
 public:
  static constexpr std::size_t kNoParent = static_cast<std::size_t>(-1);

  explicit NodeTree(const tinygltf::Model& model);

  std::size_t parent(std::size_t node) const { return parents_[node]; }
  /// All nodes, each behind its parent.
  const std::vector<std::size_t>& parents_first() const { return parents_first_; }
  /// The nodes of the default scene (or the first, or all where there is none), depth first.
  const std::vector<std::size_t>& scene_nodes() const { return scene_nodes_; }

 private:
  std::vector<std::size_t> parents_;
  std::vector<std::size_t> parents_first_;
  std::vector<std::size_t> scene_nodes_;
};

/// Everything that moves, at one time. Indexed by node.
struct Pose {
  std::vector<Affine> world;
  std::vector<std::vector<double>> weights;  ///< of the morph targets of the node's mesh
};

/// What the clip does not animate, or everything without a clip, stands as in the file. Throws Problem.
Pose pose_at(const tinygltf::Model& model, const NodeTree& tree, const Clip* clip, double time);

}  // namespace stbvh::harness::gltf
