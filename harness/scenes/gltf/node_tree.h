/// Which nodes of a glTF file stand below which, and which belong to a scene.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "harness/scenes/gltf/model.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::gltf {

/// Parents, and an order to walk in. The nodes are a forest, or the constructor throws Problem.
class NodeTree {
 public:
  static constexpr std::size_t kNoParent = static_cast<std::size_t>(-1);

  explicit NodeTree(const Model& model);

  std::size_t parent(std::size_t node) const { return parents_[node]; }
  /// All nodes depth first, so each behind its parent.
  const std::vector<std::size_t>& parents_first() const { return parents_first_; }
  /// Where a node stands in that order.
  std::size_t rank(std::size_t node) const { return ranks_[node]; }

 private:
  std::vector<std::size_t> parents_;
  std::vector<std::size_t> parents_first_;
  std::vector<std::size_t> ranks_;
};

/// The nodes of one scene, depth first: the one whose name or, failing that, index is `name_or_index`. If
/// that is empty, the file's default scene (or its first), or the first with a mesh where that has none, of
/// which `warn` is told; all nodes of a file without scenes. Throws Problem.
std::vector<std::size_t> nodes_of_scene(const Model& model, const NodeTree& tree,
                                        const std::string& name_or_index, const SceneWarning& warn);

}  // namespace stbvh::harness::gltf
