/// The scene graph of an Embree XML file: read once, shared where the file says so, then flattened.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "harness/scenes/affine.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::embree_xml {

struct Node;
using NodePtr = std::shared_ptr<Node>;

/// Maps its children; with more than one key linearly from key to key, the keys equidistant in time.
struct Transform {
  std::vector<Affine> keys;  ///< at least one
  std::optional<TimeRange> time_range;
};

/// Several nodes as one.
struct Group {};

/// The same radiance from all directions.
struct AmbientLight {
  Vec3f radiance;
};

struct NamedCamera {
  std::string name;
  Camera camera;
};

struct Node {
  std::variant<Group, Transform, Mesh, DirectionalLight, AmbientLight, NamedCamera> content;
  std::vector<NodePtr> children;  ///< of groups and transforms
  std::size_t leaves = 0;         ///< all below it, each as often as it is reached; it saturates
  std::size_t height = 0;         ///< longest way down to a leaf
};

/// Most leaves that a scene may have, each counted as often as it is instanced.
inline constexpr std::size_t kMaxLeaves = 1'000'000;
/// Most nodes above each other, along references too.
inline constexpr std::size_t kMaxHeight = 500;

/// A mesh, a light or a camera.
template <class Content>
NodePtr make_leaf(Content content) {
  auto node = std::make_shared<Node>();
  node->content = std::move(content);
  node->leaves = 1;
  return node;
}

/// Puts `child` below `parent`; nothing where it is null or has no leaves. False: the graph is too high.
bool add_child(Node& parent, const NodePtr& child);

/// Gives the motion of all meshes and of the uppermost transforms below `node` a time range of its own, as
/// Embree's <TimeRange> does: what is shared changes everywhere.
void set_time_range(Node& node, TimeRange range);

/// Everything below a node in world space.
struct FlatScene {
  std::vector<Mesh> meshes;
  std::vector<DirectionalLight> directional_lights;
  std::optional<Vec3f> ambient;  ///< sum of all
  std::vector<NamedCamera> cameras;
};

/// One mesh for each time that one is reached. A mesh that moves by itself, by transforms, or both gets
/// positions at the keys of all of them, the least common multiple of their segments: between those it moves
/// linearly. Lights and cameras stay at the first key. Throws Problem.
FlatScene flatten(const Node& root);

}  // namespace stbvh::harness::embree_xml
