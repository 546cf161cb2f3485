/// When the nodes of a glTF file are to be seen while a shutter is open.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "harness/scenes/gltf/model.h"
#include "harness/scenes/gltf/node_tree.h"
#include "harness/scenes/gltf/timeline.h"

namespace stbvh::harness::gltf {

/// Shares of the shutter.
struct Interval {
  double begin = 0, end = 1;

  bool is_whole() const { return begin == 0 && end == 1; }
};

/// Of each node those times at which it and all above it are visible. It changes only at keys.
class Visibility {
 public:
  /// Throws Problem where it would take more than a small part of `most_bytes`, which a file may need.
  Visibility(const Model& model, const NodeTree& tree, const Timeline& timeline, double most_bytes);

  /// Ascending, none touches another.
  const std::vector<Interval>& of(std::size_t node) const { return *intervals_[node]; }

 private:
  // Of all that follow the same keys the same.
  std::vector<std::shared_ptr<const std::vector<Interval>>> intervals_;
};

}  // namespace stbvh::harness::gltf
