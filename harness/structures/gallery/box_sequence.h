/// Sequences of boxes: what `box-sequence`, `box-sequence-tsah` and `msbvh` bound subtrees with.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "builder/build_context.h"
#include "builder/motion_bounds.h"
#include "harness/structures/gallery/boxes.h"
#include "harness/structures/gallery/gallery_tree.h"

namespace stbvh::harness::gallery {

/// Equidistant steps over [begin, end].
struct SequenceGrid {
  float begin = 0.0f, end = 1.0f;
  std::uint32_t segments = 0;  ///< 0: one box for all times
};

/// A box at each step of `grid`; interpolated in between they hold the geometry at all times of the grid.
struct BoxSequence {
  SequenceGrid grid;
  std::vector<Box4> boxes;

  /// At all times.
  Box4 whole() const;
  std::size_t bytes() const { return boxes.capacity() * sizeof(Box4); }
};

/// Makes the sequences of meshlets, on the steps of their meshes. May be asked by several threads at once.
class MeshletSequences {
 public:
  explicit MeshletSequences(const BuildContext& context);
  BoxSequence of(std::uint32_t mesh, const Meshlet& meshlet) const;

 private:
  const BuildContext& context_;
  std::vector<MotionSamples> samples_;  ///< of each mesh
};

/// Where a face of `boxes` lies beyond that of `limits` it is moved there, as long as what is inside the
/// limits stays inside the boxes between the steps, too. A box whose lower face is above its upper one holds
/// nothing.
void clip(std::span<Box4> boxes, const Box4& limits);

using SequenceOfLeaf = std::function<BoxSequence(const BinaryLeaf&)>;

/// Writes the tree below `root` in nodes of box sequences.
WrittenTree write_box_sequences(const BuildContext& context, const BinaryNode& root,
                                const SequenceOfLeaf& of_leaf);

}  // namespace stbvh::harness::gallery
