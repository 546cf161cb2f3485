#include "harness/scenes/gltf/primitive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>

#include "harness/scenes/gltf/accessor.h"
#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

std::optional<int> attribute(const std::map<std::string, int>& attributes, const std::string& name) {
  const auto found = attributes.find(name);
  return found == attributes.end() ? std::nullopt : std::optional<int>(found->second);
}

std::vector<std::uint32_t> read_indices(const tinygltf::Model& model, const tinygltf::Primitive& source,
                                        std::size_t vertex_count) {
  if (vertex_count > std::numeric_limits<std::uint32_t>::max()) fail("a mesh has {} vertices", vertex_count);
  std::vector<std::uint32_t> indices;
  if (source.indices == -1) {
    indices.resize(vertex_count);
    std::iota(indices.begin(), indices.end(), 0u);
    return indices;
  }
  indices = read_integers(model, source.indices, TINYGLTF_TYPE_SCALAR, "indices");
  for (const std::uint32_t index : indices) {
    if (index >= vertex_count) {
      fail("accessor {} (indices) has the index {}, but there are only {} vertices", source.indices, index,
           vertex_count);
    }
  }
  return indices;
}

/// Separate triangles of a strip or fan, without those that only stitch strips together.
std::vector<std::uint32_t> separate_triangles(const std::vector<std::uint32_t>& chain, bool is_fan) {
  std::vector<std::uint32_t> triangles;
  for (std::size_t i = 0; i + 2 < chain.size(); ++i) {
    const std::size_t odd = i % 2;
    const std::uint32_t a = is_fan ? chain[i + 1] : chain[i];
    const std::uint32_t b = is_fan ? chain[i + 2] : chain[i + 1 + odd];
    const std::uint32_t c = is_fan ? chain[0] : chain[i + 2 - odd];
    if (a != b && b != c && c != a) triangles.insert(triangles.end(), {a, b, c});
  }
  return triangles;
}

std::vector<std::uint32_t> read_triangles(const tinygltf::Model& model, const tinygltf::Primitive& source,
                                          std::size_t vertex_count) {
  std::vector<std::uint32_t> indices = read_indices(model, source, vertex_count);
  if (source.mode != TINYGLTF_MODE_TRIANGLES) {
    return separate_triangles(indices, source.mode == TINYGLTF_MODE_TRIANGLE_FAN);
  }
  indices.resize(indices.size() - indices.size() % 3);
  return indices;
}

Skin read_skin(const tinygltf::Model& model, int index) {
  if (index < 0 || static_cast<std::size_t>(index) >= model.skins.size()) fail("skin {} is missing", index);
  const tinygltf::Skin& source = model.skins[static_cast<std::size_t>(index)];
  Skin skin;
  for (const int joint : source.joints) {
    if (joint < 0 || static_cast<std::size_t>(joint) >= model.nodes.size()) {
      fail("skin {} refers to the missing node {}", index, joint);
    }
    skin.nodes.push_back(static_cast<std::size_t>(joint));
  }
  skin.inverse_bind.resize(skin.nodes.size());
  if (source.inverseBindMatrices == -1) return skin;
  const std::vector<double> numbers =
      read_numbers(model, source.inverseBindMatrices, TINYGLTF_TYPE_MAT4, "inverse bind matrices");
  if (numbers.size() / 16 < skin.nodes.size()) {
    fail("skin {} has {} joints, but only {} inverse bind matrices", index, skin.nodes.size(),
         numbers.size() / 16);
  }
  for (std::size_t i = 0; i < skin.nodes.size(); ++i) {
    skin.inverse_bind[i] = Affine::from_columns(std::span(numbers).subspan(16 * i).first<16>());
  }
  return skin;
}

/// Makes the weights of each vertex sum to 1. Those that are NaN, infinite or negative count as zero; a
/// vertex whose weights are all zero follows its first joint.
void normalize_weights(Influences& influences) {
  const std::size_t per_vertex = influences.per_vertex;
  for (std::size_t first = 0; first < influences.weights.size(); first += per_vertex) {
    const std::span<double> weights = std::span(influences.weights).subspan(first, per_vertex);
    double sum = 0;
    for (double& weight : weights) {
      if (!std::isfinite(weight) || weight < 0) weight = 0;
      sum += weight;
    }
    if (sum == 0) weights[0] = sum = 1;
    for (double& weight : weights) weight /= sum;
  }
}

/// JOINTS_0, WEIGHTS_0 and further sets, side by side for each vertex. None: nothing is skinned.
Influences read_influences(const tinygltf::Model& model, const tinygltf::Primitive& source,
                           std::size_t vertex_count, std::size_t joint_count) {
  std::vector<std::vector<std::uint32_t>> joints;
  std::vector<std::vector<double>> weights;
  for (int set = 0;; ++set) {
    const std::string joints_name = fmt::format("JOINTS_{}", set),
                      weights_name = fmt::format("WEIGHTS_{}", set);
    const auto joints_of_set = attribute(source.attributes, joints_name);
    const auto weights_of_set = attribute(source.attributes, weights_name);
    if (!joints_of_set || !weights_of_set) break;
    joints.push_back(read_integers(model, *joints_of_set, TINYGLTF_TYPE_VEC4, joints_name));
    weights.push_back(read_numbers(model, *weights_of_set, TINYGLTF_TYPE_VEC4, weights_name));
    if (joints.back().size() != 4 * vertex_count || weights.back().size() != 4 * vertex_count) {
      fail("{} and {} do not have as many elements as there are vertices", joints_name, weights_name);
    }
  }
  Influences influences;
  influences.per_vertex = 4 * joints.size();
  influences.joints.reserve(vertex_count * influences.per_vertex);
  influences.weights.reserve(vertex_count * influences.per_vertex);
  for (std::size_t vertex = 0; vertex < vertex_count; ++vertex) {
    for (std::size_t set = 0; set < joints.size(); ++set) {
      const auto first = static_cast<std::ptrdiff_t>(4 * vertex);
      influences.joints.insert(influences.joints.end(), joints[set].begin() + first,
                               joints[set].begin() + first + 4);
      influences.weights.insert(influences.weights.end(), weights[set].begin() + first,
                                weights[set].begin() + first + 4);
    }
  }
  if (influences.per_vertex > 0) normalize_weights(influences);
  for (std::size_t i = 0; i < influences.joints.size(); ++i) {
    if (influences.weights[i] > 0 && influences.joints[i] >= joint_count) {
      fail("a vertex follows joint {} of a skin with {} joints", influences.joints[i], joint_count);
    }
  }
  return influences;
}

/// The matrix of each joint; a skin's own node does not appear in it. None without a skin.
std::vector<Affine> joint_matrices(const Primitive& primitive, const Pose& pose) {
  std::vector<Affine> matrices;
  if (!primitive.skin) return matrices;
  const Skin& skin = *primitive.skin;
  for (std::size_t i = 0; i < skin.nodes.size(); ++i) {
    matrices.push_back(pose.world[skin.nodes[i]] * skin.inverse_bind[i]);
  }
  return matrices;
}

Vec3 morphed(const Primitive& primitive, const std::vector<double>& weights, std::size_t vertex) {
  const double* const p = &primitive.positions[3 * vertex];
  Vec3 position{p[0], p[1], p[2]};
  const std::size_t count = std::min(primitive.targets.size(), weights.size());
  for (std::size_t t = 0; t < count; ++t) {
    if (weights[t] == 0 || primitive.targets[t].empty()) continue;
    for (std::size_t i = 0; i < 3; ++i) position[i] += weights[t] * primitive.targets[t][3 * vertex + i];
  }
  return position;
}

Affine blended(const Influences& influences, const std::vector<Affine>& joints, std::size_t vertex) {
  Affine blend = Affine::zero();
  const std::size_t first = vertex * influences.per_vertex;
  for (std::size_t i = first; i < first + influences.per_vertex; ++i) {
    if (influences.weights[i] > 0) blend.add_scaled(joints[influences.joints[i]], influences.weights[i]);
  }
  return blend;
}

/// Values that float cannot hold become infinite, which the builders leave out and count.
float rounded(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (std::abs(value) <= kLargest || std::isnan(value)) return static_cast<float>(value);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return value > 0 ? kInfinity : -kInfinity;
}

/// A vertex of the primitive in world space.
Vec3f place(const Primitive& primitive, const Pose& pose, const std::vector<Affine>& joints,
            std::size_t vertex) {
  const Vec3 p = morphed(primitive, pose.weights[primitive.node], vertex);
  const Vec3 q = primitive.skin ? blended(primitive.influences, joints, vertex).apply(p)
                                : pose.world[primitive.node].apply(p);
  return {rounded(q[0]), rounded(q[1]), rounded(q[2])};
}

bool has_triangles(int mode) {
  return mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
         mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

}  // namespace

std::optional<Primitive> read_primitive(const tinygltf::Model& model, std::size_t node,
                                        const tinygltf::Primitive& source) {
  const auto position = attribute(source.attributes, "POSITION");
  if (!has_triangles(source.mode) || !position) return std::nullopt;
  Primitive primitive;
  primitive.node = node;
  primitive.positions = read_numbers(model, *position, TINYGLTF_TYPE_VEC3, "POSITION");
  primitive.indices = read_triangles(model, source, primitive.vertex_count());
  if (primitive.indices.empty()) return std::nullopt;
  for (const auto& target : source.targets) {
    std::vector<double>& offsets = primitive.targets.emplace_back();
    const auto moved = attribute(target, "POSITION");
    if (!moved) continue;
    offsets = read_numbers(model, *moved, TINYGLTF_TYPE_VEC3, "POSITION of a morph target");
    if (offsets.size() != primitive.positions.size()) {
      fail("a morph target has {} vertices, its mesh {}", offsets.size() / 3, primitive.vertex_count());
    }
  }
  if (const int skin = model.nodes[node].skin; skin != -1) {
    primitive.skin = read_skin(model, skin);
    primitive.influences =
        read_influences(model, source, primitive.vertex_count(), primitive.skin->nodes.size());
    if (primitive.influences.per_vertex == 0) primitive.skin.reset();
  }
  return primitive;
}

VertexBuffer deform(const Primitive& primitive, const Pose& pose) {
  const std::vector<Affine> joints = joint_matrices(primitive, pose);
  VertexBuffer buffer(primitive.vertex_count());
  for (std::size_t vertex = 0; vertex < primitive.vertex_count(); ++vertex)
    buffer[vertex] = place(primitive, pose, joints, vertex);
  return buffer;
}

Vec3f deform_vertex(const Primitive& primitive, const Pose& pose, std::size_t vertex) {
  return place(primitive, pose, joint_matrices(primitive, pose), vertex);
}

}  // namespace stbvh::harness::gltf
