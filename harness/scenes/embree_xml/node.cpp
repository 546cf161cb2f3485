#include "harness/scenes/embree_xml/node.h"

#include <algorithm>
#include <limits>
#include <unordered_set>

namespace stbvh::harness::embree_xml {
namespace {

void set_time_range(Node& node, TimeRange range, std::unordered_set<const Node*>& visited) {
  if (!visited.insert(&node).second) return;
  if (auto* const transform = std::get_if<Transform>(&node.content)) {
    transform->time_range = range;
    return;
  }
  if (auto* const mesh = std::get_if<Mesh>(&node.content)) mesh->time_range = range;
  for (const NodePtr& child : node.children) set_time_range(*child, range, visited);
}

}  // namespace

bool add_child(Node& parent, const NodePtr& child) {
  if (child == nullptr || child->leaves == 0) return true;
  parent.children.push_back(child);
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  parent.leaves = child->leaves > kMost - parent.leaves ? kMost : parent.leaves + child->leaves;
  parent.height = std::max(parent.height, child->height + 1);
  return parent.height <= kMaxHeight;
}

void set_time_range(Node& node, TimeRange range) {
  std::unordered_set<const Node*> visited;
  set_time_range(node, range, visited);
}

}  // namespace stbvh::harness::embree_xml
