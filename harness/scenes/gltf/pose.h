/// Where the nodes and joints of a glTF file are at one time of a clip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/model.h"
#include "harness/scenes/gltf/node_tree.h"
#include "harness/scenes/gltf/transform.h"

namespace stbvh::harness::gltf {

/// The joints of a skin: node and inverse bind matrix of each.
struct Skin {
  std::vector<std::size_t> nodes;
  std::vector<Affine> inverse_bind;
};

/// Everything that moves, at one time. Indexed by Rig::slot.
struct Pose {
  std::vector<Affine> world;
  std::vector<std::vector<double>> weights;  ///< of the morph targets of its mesh, where they are animated
  std::vector<bool> visible;                 ///< the node and all above it that the rig has
};

/// What else than a matrix scales a node may be left out: cameras and lights follow only how it is turned.
enum class Scaling { kAsInFile, kNone };

/// Nodes, skins and the channels that move them: all of a file, or the few that one mesh follows. Refers to
/// model, tree, clip and skins.
class Rig {
 public:
  /// Of a whole file. `skins` is indexed as there; those that are not used may be empty.
  Rig(const Model& model, const NodeTree& tree, const Clip* clip, const std::vector<Skin>& skins);

  /// A node and all above it.
  Rig chain(std::size_t node) const;

  /// What a mesh follows: its node, and joints of a skin if it has one.
  struct Follows {
    std::size_t node;
    std::optional<std::size_t> skin;
    std::span<const std::uint32_t> joints;
  };
  /// What some meshes follow together, of a whole file: their nodes and joints, and those above that have
  /// channels. What stands still between them is one map, so that it does not matter how deep a node is.
  Rig part(std::span<const Follows> meshes) const;

  /// The place of a node of the file in a pose.
  std::size_t slot(std::size_t node) const;

  /// What the clip does not animate, or everything without a clip, stands as in the file.
  Pose pose(double time, Side side = Side::kAfter, Scaling scaling = Scaling::kAsInFile) const;

  /// Of the morph targets of the mesh at a node; none: all are 0.
  const std::vector<double>& weights(const Pose& pose, std::size_t node) const;

  /// What moves vertices with a joint of a skin.
  Affine joint(const Pose& pose, std::size_t skin, std::size_t joint) const;

  /// Whether the clip moves a node or one above it; or the mesh at it, with that skin.
  bool moves(std::size_t node) const { return moves_[slot(node)]; }
  bool moves_mesh(std::size_t node, std::optional<std::size_t> skin) const;
  /// Whether the clip shows and hides a node or one above it.
  bool blinks(std::size_t node) const { return blinks_[slot(node)]; }

  /// Ordered by the rank of what they move.
  const std::vector<const Channel*>& channels() const { return channels_; }
  /// Those of one node, in the order of the file: the last of a property has its way.
  std::span<const Channel* const> channels_of(std::size_t node) const;

 private:
  enum class Kind { kChain, kPart };
  Rig(const Rig& whole, std::vector<std::size_t> nodes, Kind kind);
  void sum_up_rests();
  std::size_t slot_of_rank(std::size_t rank) const;
  void add_channels(const Clip& clip);
  void find_what_moves();
  void rest(Pose& pose, std::vector<TranslationRotationScale>& transforms) const;

  const Model& model_;
  const NodeTree& tree_;
  const std::vector<Skin>& skins_;
  std::vector<std::size_t> nodes_;  ///< of the file, in the tree's order
  std::vector<std::size_t> above_;  ///< slot of the next node above that the rig has, or kNoParent
  std::vector<Affine> between_;     ///< what stands still between a node and that; empty: nothing
  std::vector<const Channel*> channels_;
  std::vector<std::size_t> channel_ranks_;  ///< of the node that each moves
  std::vector<bool> moves_, blinks_;
  // Of a whole file: which skins move, and of each node the next above that has channels and what is between.
  std::vector<bool> moves_skins_;
  std::vector<std::size_t> anchors_;
  std::vector<Affine> rests_;
};

}  // namespace stbvh::harness::gltf
