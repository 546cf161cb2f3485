#include "harness/scenes/gltf/pose.h"

#include <algorithm>
#include <span>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

std::size_t checked_node(const tinygltf::Model& model, int node, const char* who) {
  if (node < 0 || static_cast<std::size_t>(node) >= model.nodes.size()) {
    fail("{} refers to the missing node {}", who, node);
  }
  return static_cast<std::size_t>(node);
}

std::vector<std::size_t> find_parents(const tinygltf::Model& model) {
  std::vector<std::size_t> parents(model.nodes.size(), NodeTree::kNoParent);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    for (const int index : model.nodes[i].children) {
      const std::size_t child = checked_node(model, index, "a node");
      if (parents[child] != NodeTree::kNoParent) fail("node {} is the child of more than one node", child);
      parents[child] = i;
    }
  }
  return parents;
}

/// `roots` and all below them, depth first, without recursion: files may be deep.
std::vector<std::size_t> walk(const tinygltf::Model& model, std::vector<std::size_t> roots) {
  std::vector<std::size_t> order;
  std::reverse(roots.begin(), roots.end());
  for (std::vector<std::size_t>& open = roots; !open.empty();) {
    const std::size_t node = open.back();
    open.pop_back();
    order.push_back(node);
    const std::vector<int>& children = model.nodes[node].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      open.push_back(static_cast<std::size_t>(*child));
    }
  }
  return order;
}

const tinygltf::Scene* default_scene(const tinygltf::Model& model) {
  if (model.defaultScene < 0) return model.scenes.empty() ? nullptr : &model.scenes.front();
  if (static_cast<std::size_t>(model.defaultScene) >= model.scenes.size()) {
    fail("its default scene {} is missing", model.defaultScene);
  }
  return &model.scenes[static_cast<std::size_t>(model.defaultScene)];
}

template <std::size_t N>
void take(const std::vector<double>& numbers, std::size_t node, const char* what,
          std::array<double, N>& target) {
  if (numbers.empty()) return;
  if (numbers.size() != N)
    fail("the {} of node {} has {} numbers instead of {}", what, node, numbers.size(), N);
  std::copy(numbers.begin(), numbers.end(), target.begin());
}

TranslationRotationScale resting_transform(const tinygltf::Model& model, std::size_t node) {
  const tinygltf::Node& source = model.nodes[node];
  TranslationRotationScale transform;
  take(source.translation, node, "translation", transform.translation);
  take(source.rotation, node, "rotation", transform.rotation);
  take(source.scale, node, "scale", transform.scale);
  return transform;
}

std::vector<double> resting_weights(const tinygltf::Model& model, std::size_t node) {
  const tinygltf::Node& source = model.nodes[node];
  if (!source.weights.empty() || source.mesh < 0 ||
      static_cast<std::size_t>(source.mesh) >= model.meshes.size()) {
    return source.weights;
  }
  return model.meshes[static_cast<std::size_t>(source.mesh)].weights;
}

Affine local_matrix(const tinygltf::Model& model, std::size_t node,
                    const TranslationRotationScale& transform) {
  if (model.nodes[node].matrix.empty()) return transform.matrix();
  std::array<double, 16> columns{};
  take(model.nodes[node].matrix, node, "matrix", columns);
  return Affine::from_columns(columns);
}

}  // namespace

NodeTree::NodeTree(const tinygltf::Model& model) : parents_(find_parents(model)) {
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < parents_.size(); ++i) {
    if (parents_[i] == kNoParent) roots.push_back(i);
  }
  parents_first_ = walk(model, roots);
  // Each node has one parent at most, so the only nodes that no root leads to are those on and below cycles.
  if (parents_first_.size() != parents_.size()) fail("its nodes form a cycle");

  if (const tinygltf::Scene* scene = default_scene(model)) {
    roots.clear();
    std::vector<bool> listed(parents_.size(), false);
    for (const int index : scene->nodes) {
      const std::size_t node = checked_node(model, index, "the scene");
      if (listed[node]) fail("node {} is listed twice in the scene", node);
      if (parents_[node] != kNoParent)
        fail("node {} of the scene is not a root, but below node {}", node, parents_[node]);
      listed[node] = true;
      roots.push_back(node);
    }
  }
  scene_nodes_ = walk(model, roots);
}

Pose pose_at(const tinygltf::Model& model, const NodeTree& tree, const Clip* clip, double time) {
  const std::size_t count = model.nodes.size();
  Pose pose;
  std::vector<TranslationRotationScale> transforms;
  for (std::size_t i = 0; i < count; ++i) {
    transforms.push_back(resting_transform(model, i));
    pose.weights.push_back(resting_weights(model, i));
  }
  for (const Channel& channel :
       clip ? std::span<const Channel>(clip->channels) : std::span<const Channel>()) {
    TranslationRotationScale& transform = transforms[channel.node];
    switch (channel.property) {
      case AnimatedProperty::kTranslation:
        channel.evaluate(time, transform.translation);
        break;
      case AnimatedProperty::kRotation:
        channel.evaluate(time, transform.rotation);
        break;
      case AnimatedProperty::kScale:
        channel.evaluate(time, transform.scale);
        break;
      case AnimatedProperty::kWeights:
        pose.weights[channel.node].resize(channel.width);
        channel.evaluate(time, pose.weights[channel.node]);
        break;
    }
  }
  pose.world.resize(count);
  for (const std::size_t node : tree.parents_first()) {
    const Affine local = local_matrix(model, node, transforms[node]);
    const std::size_t parent = tree.parent(node);
    pose.world[node] = parent == NodeTree::kNoParent ? local : pose.world[parent] * local;
  }
  return pose;
}

}  // namespace stbvh::harness::gltf
