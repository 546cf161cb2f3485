#include "harness/scenes/gltf/pose.h"

#include <algorithm>
#include <numeric>
#include <unordered_set>
#include <utility>

namespace stbvh::harness::gltf {
namespace {

const std::vector<double>& resting_weights(const Model& model, std::size_t node) {
  const Model::Node& source = model.nodes[node];
  const bool has_mesh = source.mesh && *source.mesh < model.meshes.size();
  return source.weights.empty() && has_mesh ? model.meshes[*source.mesh].weights : source.weights;
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
      weights.resize(channel.width);
      channel.evaluate(time, side, weights);
      break;
    case AnimatedProperty::kWeight:
      if (channel.target.weight < weights.size())
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
    : model_(model), tree_(tree), skins_(skins), nodes_(tree.parents_first()), skin_slots_(skins.size()) {
  std::iota(skin_slots_.begin(), skin_slots_.end(), std::size_t{0});
  if (clip != nullptr) {
    for (const Channel& channel : clip->channels) channels_.push_back(&channel);
  }
  std::stable_sort(channels_.begin(), channels_.end(), [&](const Channel* a, const Channel* b) {
    return tree.rank(a->target.node) < tree.rank(b->target.node);
  });
  find_what_moves();
}

Rig::Rig(const Rig& whole, std::vector<std::size_t> nodes, std::vector<std::size_t> skins)
    : model_(whole.model_),
      tree_(whole.tree_),
      skins_(whole.skins_),
      nodes_(std::move(nodes)),
      skin_slots_(std::move(skins)) {
  struct ByRank {
    const NodeTree& tree;
    bool operator()(const Channel* channel, std::size_t rank) const {
      return tree.rank(channel->target.node) < rank;
    }
    bool operator()(std::size_t rank, const Channel* channel) const {
      return rank < tree.rank(channel->target.node);
    }
  };
  for (const std::size_t node : nodes_) {
    const auto [first, last] =
        std::equal_range(whole.channels_.begin(), whole.channels_.end(), tree_.rank(node), ByRank{tree_});
    channels_.insert(channels_.end(), first, last);
  }
  find_what_moves();
}

Rig Rig::part(std::size_t node, std::optional<std::size_t> skin) const {
  std::unordered_set<std::size_t> found;
  const auto add_with_parents = [&](std::size_t at) {
    while (at != NodeTree::kNoParent && found.insert(at).second) at = tree_.parent(at);
  };
  add_with_parents(node);
  std::vector<std::size_t> skins;
  if (skin) {
    skins.push_back(*skin);
    for (const std::size_t joint : skins_[*skin].nodes) add_with_parents(joint);
  }
  std::vector<std::size_t> nodes(found.begin(), found.end());
  std::sort(nodes.begin(), nodes.end(),
            [&](std::size_t a, std::size_t b) { return tree_.rank(a) < tree_.rank(b); });
  return {*this, std::move(nodes), std::move(skins)};
}

void Rig::find_what_moves() {
  moves_.resize(nodes_.size());
  blinks_.resize(nodes_.size());
  for (const Channel* channel : channels_) {
    const std::size_t i = slot(channel->target.node);
    const AnimatedProperty property = channel->target.property;
    if (property == AnimatedProperty::kVisibility) blinks_[i] = true;
    if (property == AnimatedProperty::kTranslation || property == AnimatedProperty::kRotation ||
        property == AnimatedProperty::kScale)
      moves_[i] = true;
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (tree_.parent(nodes_[i]) == NodeTree::kNoParent) continue;
    const std::size_t parent = slot(tree_.parent(nodes_[i]));
    if (moves_[parent]) moves_[i] = true;
    if (blinks_[parent]) blinks_[i] = true;
  }
}

std::size_t Rig::slot(std::size_t node) const {
  const std::size_t rank = tree_.rank(node);
  if (nodes_.size() == tree_.parents_first().size()) return rank;
  const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), rank,
                                      [&](std::size_t n, std::size_t r) { return tree_.rank(n) < r; });
  return static_cast<std::size_t>(found - nodes_.begin());
}

std::size_t Rig::skin_slot(std::size_t skin) const {
  return static_cast<std::size_t>(std::lower_bound(skin_slots_.begin(), skin_slots_.end(), skin) -
                                  skin_slots_.begin());
}

bool Rig::moves_mesh(std::size_t node, std::optional<std::size_t> skin) const {
  const auto at = [&](const Channel* channel) { return tree_.rank(channel->target.node); };
  const auto first = std::partition_point(channels_.begin(), channels_.end(), [&](const Channel* channel) {
    return at(channel) < tree_.rank(node);
  });
  for (auto channel = first; channel != channels_.end() && (*channel)->target.node == node; ++channel) {
    const AnimatedProperty property = (*channel)->target.property;
    if (property == AnimatedProperty::kWeights || property == AnimatedProperty::kWeight) return true;
  }
  if (!skin) return moves(node);
  const std::vector<std::size_t>& joints = skins_[*skin].nodes;
  return std::any_of(joints.begin(), joints.end(), [&](std::size_t joint) { return moves(joint); });
}

/// As in the file.
void Rig::rest(Pose& pose, std::vector<TranslationRotationScale>& transforms) const {
  const std::size_t count = nodes_.size();
  transforms.reserve(count);
  pose.weights.reserve(count);
  pose.visible.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    transforms.push_back(model_.nodes[nodes_[i]].transform);
    pose.weights.push_back(resting_weights(model_, nodes_[i]));
    pose.visible[i] = model_.nodes[nodes_[i]].is_visible;
  }
}

Pose Rig::pose(double time, Side side, Scaling scaling) const {
  Pose pose;
  std::vector<TranslationRotationScale> transforms;
  rest(pose, transforms);
  for (const Channel* channel : channels_) {
    const std::size_t i = slot(channel->target.node);
    bool is_visible = pose.visible[i];
    apply(*channel, time, side, transforms[i], pose.weights[i], is_visible);
    pose.visible[i] = is_visible;
  }
  if (scaling == Scaling::kNone) {
    for (TranslationRotationScale& transform : transforms) transform.scale = {1, 1, 1};
  }
  pose.world.resize(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Model::Node& source = model_.nodes[nodes_[i]];
    pose.world[i] = source.matrix ? Affine::from_columns(*source.matrix) : transforms[i].matrix();
    if (tree_.parent(nodes_[i]) == NodeTree::kNoParent) continue;
    const std::size_t parent = slot(tree_.parent(nodes_[i]));
    pose.world[i] = pose.world[parent] * pose.world[i];
    pose.visible[i] = pose.visible[i] && pose.visible[parent];
  }
  for (const std::size_t skin : skin_slots_) {
    std::vector<Affine>& joints = pose.joints.emplace_back();
    for (std::size_t j = 0; j < skins_[skin].nodes.size(); ++j)
      joints.push_back(pose.world[slot(skins_[skin].nodes[j])] * skins_[skin].inverse_bind[j]);
  }
  return pose;
}

}  // namespace stbvh::harness::gltf
