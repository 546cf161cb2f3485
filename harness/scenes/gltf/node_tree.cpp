#include "harness/scenes/gltf/node_tree.h"

#include <algorithm>
#include <utility>

#include "harness/scenes/gltf/named.h"
#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

std::size_t checked_node(const Model& model, std::size_t node, const char* who) {
  if (node >= model.nodes.size()) fail("{} refers to the missing node {}", who, node);
  return node;
}

std::vector<std::size_t> find_parents(const Model& model) {
  std::vector<std::size_t> parents(model.nodes.size(), NodeTree::kNoParent);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    for (const std::size_t index : model.nodes[i].children) {
      const std::size_t child = checked_node(model, index, "a node");
      if (parents[child] != NodeTree::kNoParent) fail("node {} is the child of more than one node", child);
      parents[child] = i;
    }
  }
  return parents;
}

/// `roots` and all below them, depth first, without recursion: files may be deep.
std::vector<std::size_t> walk(const Model& model, std::vector<std::size_t> roots) {
  std::vector<std::size_t> order;
  std::reverse(roots.begin(), roots.end());
  for (std::vector<std::size_t>& open = roots; !open.empty();) {
    const std::size_t node = open.back();
    open.pop_back();
    order.push_back(node);
    const std::vector<std::size_t>& children = model.nodes[node].children;
    open.insert(open.end(), children.rbegin(), children.rend());
  }
  return order;
}

/// The roots of a scene, checked.
std::vector<std::size_t> roots_of(const Model& model, const NodeTree& tree, const Model::Scene& scene) {
  std::vector<std::size_t> roots;
  std::vector<bool> listed(model.nodes.size(), false);
  for (const std::size_t index : scene.nodes) {
    const std::size_t node = checked_node(model, index, "the scene");
    if (listed[node]) fail("node {} is listed twice in the scene", node);
    if (tree.parent(node) != NodeTree::kNoParent)
      fail("node {} of the scene is not a root, but below node {}", node, tree.parent(node));
    listed[node] = true;
    roots.push_back(node);
  }
  return roots;
}

/// Whether there is a mesh at or below each node.
std::vector<bool> find_meshes_below(const Model& model, const NodeTree& tree) {
  std::vector<bool> has_mesh(model.nodes.size(), false);
  const std::vector<std::size_t>& order = tree.parents_first();
  for (auto node = order.rbegin(); node != order.rend(); ++node) {
    if (model.nodes[*node].mesh) has_mesh[*node] = true;
    if (has_mesh[*node] && tree.parent(*node) != NodeTree::kNoParent) has_mesh[tree.parent(*node)] = true;
  }
  return has_mesh;
}

/// The default scene, or the first with a mesh where that has none.
std::size_t scene_to_show(const Model& model, const NodeTree& tree, const SceneWarning& warn) {
  const std::size_t standard = model.default_scene.value_or(0);
  if (standard >= model.scenes.size()) fail("its default scene {} is missing", standard);
  const std::vector<bool> has_mesh = find_meshes_below(model, tree);
  const auto shows_something = [&](const Model::Scene& scene) {
    return std::any_of(scene.nodes.begin(), scene.nodes.end(),
                       [&](std::size_t node) { return node < has_mesh.size() && has_mesh[node]; });
  };
  if (shows_something(model.scenes[standard])) return standard;
  const auto other = std::find_if(model.scenes.begin(), model.scenes.end(), shows_something);
  if (other == model.scenes.end()) return standard;
  const auto index = static_cast<std::size_t>(other - model.scenes.begin());
  warn(fmt::format("its scene {} is empty; scene {} is shown", standard, index));
  return index;
}

}  // namespace

NodeTree::NodeTree(const Model& model) : parents_(find_parents(model)), ranks_(parents_.size()) {
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < parents_.size(); ++i) {
    if (parents_[i] == kNoParent) roots.push_back(i);
  }
  parents_first_ = walk(model, std::move(roots));
  // Each node has one parent at most, so the only nodes that no root leads to are those on and below cycles.
  if (parents_first_.size() != parents_.size()) fail("its nodes form a cycle");
  for (std::size_t i = 0; i < ranks_.size(); ++i) ranks_[parents_first_[i]] = i;
}

std::vector<std::size_t> nodes_of_scene(const Model& model, const NodeTree& tree,
                                        const std::string& name_or_index, const SceneWarning& warn) {
  if (!name_or_index.empty())
    return walk(model, roots_of(model, tree, find_named(model.scenes, name_or_index, "scene")));
  if (model.scenes.empty() && !model.default_scene) return tree.parents_first();
  return walk(model, roots_of(model, tree, model.scenes[scene_to_show(model, tree, warn)]));
}

}  // namespace stbvh::harness::gltf
