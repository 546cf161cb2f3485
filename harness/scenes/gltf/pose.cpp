#include "harness/scenes/gltf/pose.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

namespace stbvh::harness::gltf {
namespace {

const std::vector<double>& resting_weights(const Model& model, std::size_t node) {
  const Model::Node& source = model.nodes[node];
  const bool has_mesh = source.mesh && *source.mesh < model.meshes.size();
  return source.weights.empty() && has_mesh ? model.meshes[*source.mesh].weights : source.weights;
}

Affine resting_map(const Model::Node& node) {
  return node.matrix ? Affine::from_columns(*node.matrix) : node.transform.matrix();
}

void apply(const Channel& channel, double time, Side side, TranslationRotationScale& transform,
           std::vector<double>& weights, bool& is_visible) {
  switch (channel.target.property) {
    case AnimatedProperty::kTranslation:
      channel.evaluate(time, side, transform.translation);
      break;
    case AnimatedProperty::kRotation:
      channel.evaluate(time, side, transform.rotation);
      break;
    case AnimatedProperty::kScale:
      channel.evaluate(time, side, transform.scale);
      break;
    case AnimatedProperty::kWeights:
      channel.evaluate(time, side, weights);
      break;
    case AnimatedProperty::kWeight:
      channel.evaluate(time, side, std::span(weights).subspan(channel.target.weight, 1));
      break;
    case AnimatedProperty::kVisibility: {
      double value = 1;
      channel.evaluate(time, side, {&value, 1});
      is_visible = value != 0;
      break;
    }
  }
}

}  // namespace

Rig::Rig(const Model& model, const NodeTree& tree, const Clip* clip, const std::vector<Skin>& skins)
    : model_(model), tree_(tree), skins_(skins), nodes_(tree.parents_first()) {
  if (clip != nullptr) add_channels(*clip);
  for (const std::size_t node : nodes_) {
    const std::size_t parent = tree.parent(node);
    above_.push_back(parent == NodeTree::kNoParent ? parent : slot(parent));
  }
  find_what_moves();
  for (const Skin& skin : skins) {
    moves_skins_.push_back(
        std::any_of(skin.nodes.begin(), skin.nodes.end(), [&](std::size_t joint) { return moves(joint); }));
  }
  sum_up_rests();
}

/// In the tree's order, so that each node adds one map to those of its parent.
void Rig::sum_up_rests() {
  anchors_.resize(nodes_.size(), NodeTree::kNoParent);
  rests_.resize(nodes_.size());
  for (const std::size_t node : nodes_) {
    const std::size_t parent = tree_.parent(node);
    if (parent == NodeTree::kNoParent) continue;
    if (!channels_of(parent).empty()) {
      anchors_[node] = parent;
      continue;
    }
    anchors_[node] = anchors_[parent];
    rests_[node] = rests_[parent] * resting_map(model_.nodes[parent]);
  }
}

/// What moves the weights of a mesh comes before what moves those of its nodes.
void Rig::add_channels(const Clip& clip) {
  struct Moved {
    std::size_t rank;
    const Channel* channel;
  };
  const TargetNodes nodes(model_);
  std::vector<Moved> all;
  for (const bool of_meshes : {true, false}) {
    for (const Channel& channel : clip.channels) {
      if (channel.target.mesh.has_value() != of_meshes) continue;
      for (const std::size_t node : nodes.of(channel.target)) all.push_back({tree_.rank(node), &channel});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Moved& a, const Moved& b) { return a.rank < b.rank; });
  for (const Moved& moved : all) {
    channels_.push_back(moved.channel);
    channel_ranks_.push_back(moved.rank);
  }
}

Rig::Rig(const Rig& whole, std::vector<std::size_t> nodes, Kind kind)
    : model_(whole.model_), tree_(whole.tree_), skins_(whole.skins_), nodes_(std::move(nodes)) {
  std::sort(nodes_.begin(), nodes_.end(),
            [&](std::size_t a, std::size_t b) { return tree_.rank(a) < tree_.rank(b); });
  for (const std::size_t node : nodes_) {
    const std::size_t above = kind == Kind::kPart ? whole.anchors_[node] : tree_.parent(node);
    above_.push_back(above == NodeTree::kNoParent ? above : slot(above));
    if (kind == Kind::kPart) between_.push_back(whole.rests_[node]);
  }
  for (const std::size_t node : nodes_) {
    const auto own = whole.channels_of(node);
    channels_.insert(channels_.end(), own.begin(), own.end());
    channel_ranks_.insert(channel_ranks_.end(), own.size(), tree_.rank(node));
  }
  find_what_moves();
}

std::span<const Channel* const> Rig::channels_of(std::size_t node) const {
  const auto [first, last] = std::equal_range(channel_ranks_.begin(), channel_ranks_.end(), tree_.rank(node));
  return std::span(channels_).subspan(static_cast<std::size_t>(first - channel_ranks_.begin()),
                                      static_cast<std::size_t>(last - first));
}

Rig Rig::chain(std::size_t node) const {
  std::vector<std::size_t> nodes;
  for (std::size_t at = node; at != NodeTree::kNoParent; at = tree_.parent(at)) nodes.push_back(at);
  return {*this, std::move(nodes), Kind::kChain};
}

Rig Rig::part(std::span<const Follows> meshes) const {
  std::unordered_set<std::size_t> found;
  const auto add_with_anchors = [&](std::size_t at) {
    while (at != NodeTree::kNoParent && found.insert(at).second) at = anchors_[at];
  };
  for (const Follows& mesh : meshes) {
    add_with_anchors(mesh.node);
    for (const std::uint32_t joint : mesh.joints) add_with_anchors(skins_[*mesh.skin].nodes[joint]);
  }
  return {*this, {found.begin(), found.end()}, Kind::kPart};
}

void Rig::find_what_moves() {
  moves_.resize(nodes_.size());
  blinks_.resize(nodes_.size());
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const std::size_t i = slot_of_rank(channel_ranks_[c]);
    const AnimatedProperty property = channels_[c]->target.property;
    if (property == AnimatedProperty::kVisibility) blinks_[i] = true;
    if (property == AnimatedProperty::kTranslation || property == AnimatedProperty::kRotation ||
        property == AnimatedProperty::kScale)
      moves_[i] = true;
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (above_[i] == NodeTree::kNoParent) continue;
    if (moves_[above_[i]]) moves_[i] = true;
    if (blinks_[above_[i]]) blinks_[i] = true;
  }
}

std::size_t Rig::slot(std::size_t node) const {
  return slot_of_rank(tree_.rank(node));
}

std::size_t Rig::slot_of_rank(std::size_t rank) const {
  if (nodes_.size() == tree_.parents_first().size()) return rank;
  const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), rank,
                                      [&](std::size_t n, std::size_t r) { return tree_.rank(n) < r; });
  return static_cast<std::size_t>(found - nodes_.begin());
}

Affine Rig::joint(const Pose& pose, std::size_t skin, std::size_t joint) const {
  return pose.world[slot(skins_[skin].nodes[joint])] * skins_[skin].inverse_bind[joint];
}

bool Rig::moves_mesh(std::size_t node, std::optional<std::size_t> skin) const {
  for (const Channel* channel : channels_of(node)) {
    const AnimatedProperty property = channel->target.property;
    if (property == AnimatedProperty::kWeights || property == AnimatedProperty::kWeight) return true;
  }
  return skin ? moves_skins_[*skin] : moves(node);
}

const std::vector<double>& Rig::weights(const Pose& pose, std::size_t node) const {
  const std::vector<double>& animated = pose.weights[slot(node)];
  return animated.empty() ? resting_weights(model_, node) : animated;
}

/// As in the file.
void Rig::rest(Pose& pose, std::vector<TranslationRotationScale>& transforms) const {
  const std::size_t count = nodes_.size();
  transforms.reserve(count);
  pose.weights.resize(count);
  pose.visible.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    transforms.push_back(model_.nodes[nodes_[i]].transform);
    pose.visible[i] = model_.nodes[nodes_[i]].is_visible;
  }
}

Pose Rig::pose(double time, Side side, Scaling scaling) const {
  Pose pose;
  std::vector<TranslationRotationScale> transforms;
  rest(pose, transforms);
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const std::size_t i = slot_of_rank(channel_ranks_[c]);
    const AnimatedProperty property = channels_[c]->target.property;
    const bool moves_weights =
        property == AnimatedProperty::kWeights || property == AnimatedProperty::kWeight;
    if (moves_weights && pose.weights[i].empty()) {
      pose.weights[i] = resting_weights(model_, nodes_[i]);
      pose.weights[i].resize(target_count(model_, nodes_[i]));
    }
    bool is_visible = pose.visible[i];
    apply(*channels_[c], time, side, transforms[i], pose.weights[i], is_visible);
    pose.visible[i] = is_visible;
  }
  if (scaling == Scaling::kNone) {
    for (TranslationRotationScale& transform : transforms) transform.scale = {1, 1, 1};
  }
  pose.world.resize(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Model::Node& source = model_.nodes[nodes_[i]];
    pose.world[i] = source.matrix ? Affine::from_columns(*source.matrix) : transforms[i].matrix();
    if (!between_.empty()) pose.world[i] = between_[i] * pose.world[i];
    if (above_[i] == NodeTree::kNoParent) continue;
    pose.world[i] = pose.world[above_[i]] * pose.world[i];
    pose.visible[i] = pose.visible[i] && pose.visible[above_[i]];
  }
  return pose;
}

}  // namespace stbvh::harness::gltf
