/// Where the nodes and joints of a glTF file are at one time of a clip.
#pragma once

#include <cstddef>
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

/// Everything that moves, at one time. Indexed by Rig::slot and Rig::skin_slot.
struct Pose {
  std::vector<Affine> world;
  std::vector<std::vector<double>> weights;  ///< of the morph targets of its mesh, where they are animated
  std::vector<bool> visible;                 ///< the node and all above it
  std::vector<std::vector<Affine>> joints;   ///< of each skin
};

/// What else than a matrix scales a node may be left out: cameras and lights follow only how it is turned.
enum class Scaling { kAsInFile, kNone };

/// Nodes, skins and the channels that move them: all of a file, or the few that one mesh follows. Refers to
/// model, tree, clip and skins.
class Rig {
 public:
  /// Of a whole file. `skins` is indexed as there; those that are not used may be empty.
  Rig(const Model& model, const NodeTree& tree, const Clip* clip, const std::vector<Skin>& skins);

  /// What a mesh follows: its node, and its skin if there is one.
  struct Follows {
    std::size_t node;
    std::optional<std::size_t> skin;
  };
  /// What one mesh follows, or some of them together.
  Rig part(std::size_t node, std::optional<std::size_t> skin) const;
  Rig part(std::span<const Follows> meshes) const;

  /// The place of a node of the file in a pose.
  std::size_t slot(std::size_t node) const;
  std::size_t skin_slot(std::size_t skin) const;

  /// What the clip does not animate, or everything without a clip, stands as in the file.
  Pose pose(double time, Side side = Side::kAfter, Scaling scaling = Scaling::kAsInFile) const;

  /// Of the morph targets of the mesh at a node; none: all are 0.
  const std::vector<double>& weights(const Pose& pose, std::size_t node) const;

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
  Rig(const Rig& whole, std::vector<std::size_t> nodes, std::vector<std::size_t> skins);
  std::size_t slot_of_rank(std::size_t rank) const;
  void add_channels(const Clip& clip);
  void find_what_moves();
  void rest(Pose& pose, std::vector<TranslationRotationScale>& transforms) const;

  const Model& model_;
  const NodeTree& tree_;
  const std::vector<Skin>& skins_;
  std::vector<std::size_t> nodes_;       ///< of the file, in the tree's order
  std::vector<std::size_t> skin_slots_;  ///< which skins, ascending
  std::vector<const Channel*> channels_;
  std::vector<std::size_t> channel_ranks_;  ///< of the node that each moves
  std::vector<bool> moves_, blinks_;
  std::vector<bool> moves_skins_;  ///< by skin slot
};

}  // namespace stbvh::harness::gltf
