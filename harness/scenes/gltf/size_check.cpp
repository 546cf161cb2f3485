#include "harness/scenes/gltf/size_check.h"

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "harness/scenes/gltf/accessor.h"
#include "harness/scenes/gltf/primitive.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::gltf {
namespace {

/// Enough for kMaxSceneSteps positions as floats of each vertex that stands in the file as three shorts.
constexpr double kMaxExpansion = 300;
constexpr double kFreeBytes = 1 << 30;
/// Of a mesh without vertices: names, buffers, what structures keep of it.
constexpr double kMeshBytes = 1024;
/// Of a channel for each node that it moves.
constexpr std::size_t kChannelBytes = 32;

/// Sums up bytes; in double precision, which no count of a file can overflow.
class SizeCheck {
 public:
  SizeCheck(const Model& model, const NodeTree& tree, const ClipSource* clip, std::size_t steps)
      : model_(model),
        targets_(model),
        steps_(static_cast<double>(steps)),
        moves_(find_what_moves(tree, clip)),
        has_clip_(clip != nullptr) {}

  void add_keys(const ClipSource& clip) {
    for (const ClipSource::Channel& channel : clip.channels) {
      add_numbers(channel.sampler.input, "animation times");
      add_numbers(channel.sampler.output, "animation values");
      bytes_ += static_cast<double>(targets_.of(channel.target).size() * kChannelBytes);
    }
    add_poses(clip);
  }

  void add_node(std::size_t index, const Visibility* visibility) {
    const Model::Node& node = model_.nodes[index];
    if (!node.mesh) return;
    if (*node.mesh >= model_.meshes.size()) fail("node {} refers to the missing mesh {}", index, *node.mesh);
    if (node.skin && *node.skin < model_.skins.size()) add_skin(*node.skin);
    const double instances = node.instances ? add_instances(*node.instances) : 1;
    const MeshSize& mesh = mesh_size(*node.mesh, node.skin.has_value());
    const bool moves = has_clip_ && (moves_[index] || node.skin);
    double times = 1, steps = moves ? steps_ : 1;
    if (visibility != nullptr) {
      const std::vector<Interval>& intervals = visibility->of(index);
      times = static_cast<double>(intervals.size());
      // What is not there all the time has two steps, also where it does not move.
      if (!intervals.empty() && !intervals.front().is_whole()) steps = std::max(steps, 2.0);
    }
    bytes_ += times * instances * (mesh.primitives * kMeshBytes + mesh.index_bytes + mesh.step_bytes * steps);
  }

  void check() const {
    const double most = most_bytes_of(model_);
    if (bytes_ <= most) return;
    fail("it would need {:.3g} GB with {:.0f} steps; a file of {} bytes may need {:.3g} GB", bytes_ / 1e9,
         steps_, model_.bytes, most / 1e9);
  }

 private:
  /// Of each node, whether a channel moves it or one above it.
  std::vector<bool> find_what_moves(const NodeTree& tree, const ClipSource* clip) const {
    std::vector<bool> moves(model_.nodes.size(), false);
    if (clip == nullptr) return moves;
    for (const ClipSource::Channel& channel : clip->channels) {
      if (channel.target.property == AnimatedProperty::kVisibility) continue;
      for (const std::size_t node : targets_.of(channel.target)) moves[node] = true;
    }
    for (const std::size_t node : tree.parents_first()) {
      if (tree.parent(node) != NodeTree::kNoParent && moves[tree.parent(node)]) moves[node] = true;
    }
    return moves;
  }

  /// Weights that move, of all nodes at the time of each step.
  void add_poses(const ClipSource& clip) {
    std::vector<bool> has_weights(model_.nodes.size(), false);
    for (const ClipSource::Channel& channel : clip.channels) {
      const AnimatedProperty property = channel.target.property;
      if (property != AnimatedProperty::kWeights && property != AnimatedProperty::kWeight) continue;
      for (const std::size_t node : targets_.of(channel.target)) has_weights[node] = true;
    }
    for (std::size_t node = 0; node < has_weights.size(); ++node) {
      if (has_weights[node])
        bytes_ += static_cast<double>(target_count(model_, node) * sizeof(double)) * steps_;
    }
  }

  double count(std::size_t accessor, std::string_view use) const {
    return static_cast<double>(checked_count(model_, accessor, use));
  }

  /// As they are read: in double precision.
  void add_numbers(std::size_t accessor, std::string_view use) {
    const double elements = count(accessor, use);
    bytes_ +=
        elements * static_cast<double>(component_count(model_.accessors[accessor].type)) * sizeof(double);
  }

  double index_count(const Model::Primitive& primitive) const {
    const double chain = primitive.indices ? count(*primitive.indices, "indices")
                                           : count(primitive.attributes.at("POSITION"), "POSITION");
    return primitive.mode == kTriangles ? chain : 3 * chain;
  }

  /// What each node with a mesh needs of its own.
  struct MeshSize {
    double primitives = 0, index_bytes = 0, step_bytes = 0;
  };

  /// Counts what all nodes with the mesh share when it is asked for the first time.
  const MeshSize& mesh_size(std::size_t index, bool is_skinned) {
    const auto [known, is_new] = meshes_.try_emplace({index, is_skinned});
    MeshSize& mesh = known->second;
    if (!is_new) return mesh;
    for (const Model::Primitive& primitive : model_.meshes[index].primitives) {
      if (!has_triangles(primitive)) continue;
      add_geometry(primitive, is_skinned);
      ++mesh.primitives;
      mesh.index_bytes += index_count(primitive) * sizeof(std::uint32_t);
      mesh.step_bytes += count(primitive.attributes.at("POSITION"), "POSITION") * sizeof(Vec3f) +
                         static_cast<double>(primitive.targets.size() * sizeof(double));
    }
    return mesh;
  }

  void add_geometry(const Model::Primitive& primitive, bool is_skinned) {
    bytes_ += index_count(primitive) * sizeof(std::uint32_t);
    for (const auto& [name, accessor] : primitive.attributes) {
      const bool is_influence = name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
      if (name == "POSITION" || (is_skinned && is_influence)) add_numbers(accessor, name);
    }
    for (const Model::Attributes& target : primitive.targets) {
      const auto position = target.find("POSITION");
      if (position != target.end()) add_numbers(position->second, "POSITION of a morph target");
    }
  }

  void add_skin(std::size_t index) {
    if (!skins_.insert(index).second) return;
    const Model::Skin& skin = model_.skins[index];
    if (skin.inverse_bind) add_numbers(*skin.inverse_bind, "inverse bind matrices");
  }

  double add_instances(const Model::Attributes& attributes) {
    double most = 0;
    for (const auto& [name, accessor] : attributes) {
      add_numbers(accessor, name);
      most = std::max(most, count(accessor, name));
    }
    bytes_ += most * sizeof(Affine);
    return most;
  }

  const Model& model_;
  const TargetNodes targets_;
  const double steps_;
  const std::vector<bool> moves_;
  const bool has_clip_;
  // Whose own data is counted already; of meshes with and without skin.
  std::map<std::pair<std::size_t, bool>, MeshSize> meshes_;
  std::set<std::size_t> skins_;
  double bytes_ = 0;
};

}  // namespace

double most_bytes_of(const Model& model) {
  return std::min(static_cast<double>(kMaxSceneFileBytes),
                  kFreeBytes + kMaxExpansion * static_cast<double>(model.bytes));
}

void check_sizes(const Model& model, const NodeTree& tree, const std::vector<std::size_t>& nodes,
                 const ClipSource* clip, std::size_t steps, const Visibility* visibility) {
  SizeCheck check(model, tree, clip, steps);
  if (clip != nullptr) check.add_keys(*clip);
  for (const std::size_t node : nodes) check.add_node(node, visibility);
  check.check();
}

}  // namespace stbvh::harness::gltf
