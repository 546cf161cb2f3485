#include "harness/scenes/gltf/primitive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>

#include "harness/scenes/gltf/accessor.h"
#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

Model::Index attribute(const Model::Attributes& attributes, const std::string& name) {
  const auto found = attributes.find(name);
  return found == attributes.end() ? std::nullopt : Model::Index(found->second);
}

std::vector<std::uint32_t> read_indices(const Model& model, const Model::Primitive& source,
                                        std::size_t vertex_count) {
  if (vertex_count > std::numeric_limits<std::uint32_t>::max()) fail("a mesh has {} vertices", vertex_count);
  std::vector<std::uint32_t> indices;
  if (!source.indices) {
    indices.resize(vertex_count);
    std::iota(indices.begin(), indices.end(), 0u);
    return indices;
  }
  indices = read_integers(model, *source.indices, ElementType::kScalar, "indices");
  for (const std::uint32_t index : indices) {
    if (index >= vertex_count) {
      fail("accessor {} (indices) has the index {}, but there are only {} vertices", *source.indices, index,
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

std::vector<std::uint32_t> read_triangles(const Model& model, const Model::Primitive& source,
                                          std::size_t vertex_count) {
  std::vector<std::uint32_t> indices = read_indices(model, source, vertex_count);
  if (source.mode != kTriangles) {
    return separate_triangles(indices, source.mode == kTriangleFan);
  }
  indices.resize(indices.size() - indices.size() % 3);
  return indices;
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

/// From joints of the skin to those of them that have a weight.
void number_used_joints(Influences& influences) {
  std::vector<std::uint32_t>& used = influences.used;
  for (std::size_t i = 0; i < influences.joints.size(); ++i) {
    if (influences.weights[i] > 0) used.push_back(influences.joints[i]);
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  used.shrink_to_fit();
  for (std::uint32_t& joint : influences.joints)
    joint = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), joint) - used.begin());
}

/// JOINTS_0, WEIGHTS_0 and further sets, side by side for each vertex. None: nothing is skinned.
Influences read_influences(const Model& model, const Model::Primitive& source, std::size_t vertex_count) {
  std::vector<std::vector<std::uint32_t>> joints;
  std::vector<std::vector<double>> weights;
  for (int set = 0;; ++set) {
    const std::string joints_name = fmt::format("JOINTS_{}", set),
                      weights_name = fmt::format("WEIGHTS_{}", set);
    const auto joints_of_set = attribute(source.attributes, joints_name);
    const auto weights_of_set = attribute(source.attributes, weights_name);
    if (!joints_of_set || !weights_of_set) break;
    joints.push_back(read_integers(model, *joints_of_set, ElementType::kVec4, joints_name));
    weights.push_back(read_numbers(model, *weights_of_set, ElementType::kVec4, weights_name));
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
  number_used_joints(influences);
  return influences;
}

/// A morph target that moves something.
struct Morph {
  const double* offsets;  ///< x, y, z of each vertex
  double weight;
};

std::vector<Morph> morphs(const Geometry& geometry, const std::vector<double>& weights) {
  std::vector<Morph> found;
  for (std::size_t t = 0; t < std::min(geometry.targets.size(), weights.size()); ++t) {
    if (weights[t] != 0 && !geometry.targets[t].empty())
      found.push_back({geometry.targets[t].data(), weights[t]});
  }
  return found;
}

Vec3 morphed(const Geometry& geometry, const std::vector<Morph>& morphs, std::size_t vertex) {
  const double* const p = &geometry.positions[3 * vertex];
  Vec3 position{p[0], p[1], p[2]};
  for (const Morph& morph : morphs) {
    const double* const offset = morph.offsets + 3 * vertex;
    position = position + morph.weight * Vec3{offset[0], offset[1], offset[2]};
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

/// What moves the vertices of a primitive in a pose.
struct Placement {
  const Geometry& geometry;
  std::vector<Morph> morphs;
  Affine world;
  std::vector<Affine> joints;  ///< those that are used; none: it has no skin
};

Placement placement(const Primitive& primitive, const Rig& rig, const Pose& pose) {
  const Geometry& geometry = *primitive.geometry;
  Placement at{geometry,
               morphs(geometry, rig.weights(pose, primitive.node)),
               pose.world[rig.slot(primitive.node)] * primitive.instance,
               {}};
  if (!primitive.skin) return at;
  for (const std::uint32_t joint : geometry.influences.used)
    at.joints.push_back(rig.joint(pose, *primitive.skin, joint));
  return at;
}

/// A vertex in world space.
Vec3f place(const Placement& at, std::size_t vertex) {
  const Vec3 p = morphed(at.geometry, at.morphs, vertex);
  return rounded(!at.joints.empty() ? blended(at.geometry.influences, at.joints, vertex).apply(p)
                                    : at.world.apply(p));
}

/// The element of that attribute for each instance; none where it is not there.
template <std::size_t N>
std::vector<std::array<double, N>> instance_attribute(const Model& model, std::size_t node, const char* name,
                                                      ElementType type) {
  std::vector<std::array<double, N>> elements;
  const auto accessor = attribute(*model.nodes[node].instances, name);
  if (!accessor) return elements;
  const std::vector<double> numbers = read_numbers(model, *accessor, type, name);
  elements.resize(numbers.size() / N);
  for (std::size_t i = 0; i < numbers.size(); ++i) elements[i / N][i % N] = numbers[i];
  return elements;
}

}  // namespace

bool has_triangles(const Model::Primitive& source) {
  return source.mode >= kTriangles && source.attributes.contains("POSITION") && !source.is_compressed;
}

bool has_influences(const Model::Primitive& source) {
  return source.attributes.contains("JOINTS_0") && source.attributes.contains("WEIGHTS_0");
}

std::shared_ptr<const Geometry> read_geometry(const Model& model, const Model::Primitive& source,
                                              bool is_skinned) {
  auto geometry = std::make_shared<Geometry>();
  geometry->positions = read_numbers(model, source.attributes.at("POSITION"), ElementType::kVec3, "POSITION");
  geometry->indices = read_triangles(model, source, geometry->vertex_count());
  for (const Model::Attributes& target : source.targets) {
    std::vector<double>& offsets = geometry->targets.emplace_back();
    const auto moved = attribute(target, "POSITION");
    if (!moved) continue;
    offsets = read_numbers(model, *moved, ElementType::kVec3, "POSITION of a morph target");
    if (offsets.size() != geometry->positions.size())
      fail("a morph target has {} vertices, its mesh {}", offsets.size() / 3, geometry->vertex_count());
  }
  if (is_skinned) geometry->influences = read_influences(model, source, geometry->vertex_count());
  return geometry;
}

void check_joints(const Geometry& geometry, const Skin& skin) {
  const std::vector<std::uint32_t>& used = geometry.influences.used;
  if (!used.empty() && used.back() >= skin.nodes.size()) {
    fail("a vertex follows joint {} of a skin with {} joints", used.back(), skin.nodes.size());
  }
}

Skin read_skin(const Model& model, std::size_t index) {
  if (index >= model.skins.size()) fail("skin {} is missing", index);
  const Model::Skin& source = model.skins[index];
  Skin skin;
  skin.nodes = source.joints;
  for (const std::size_t joint : skin.nodes) {
    if (joint >= model.nodes.size()) fail("skin {} refers to the missing node {}", index, joint);
  }
  skin.inverse_bind.resize(skin.nodes.size());
  if (!source.inverse_bind) return skin;
  const std::vector<double> numbers =
      read_numbers(model, *source.inverse_bind, ElementType::kMat4, "inverse bind matrices");
  if (numbers.size() / 16 < skin.nodes.size()) {
    fail("skin {} has {} joints, but only {} inverse bind matrices", index, skin.nodes.size(),
         numbers.size() / 16);
  }
  for (std::size_t i = 0; i < skin.nodes.size(); ++i) {
    skin.inverse_bind[i] = Affine::from_columns(std::span(numbers).subspan(16 * i).first<16>());
  }
  return skin;
}

std::vector<Affine> read_instances(const Model& model, std::size_t node) {
  if (!model.nodes[node].instances) return {Affine()};
  const Model::Attributes& attributes = *model.nodes[node].instances;
  if (attributes.empty()) fail("the instances of node {} have no attributes", node);
  const std::size_t count = accessor_at(model, attributes.begin()->second, "instances").count;
  for (const auto& [name, accessor] : attributes) {
    if (accessor_at(model, accessor, name).count != count)
      fail("the attributes of the instances of node {} have different counts", node);
  }
  const auto translations = instance_attribute<3>(model, node, "TRANSLATION", ElementType::kVec3);
  const auto rotations = instance_attribute<4>(model, node, "ROTATION", ElementType::kVec4);
  const auto scales = instance_attribute<3>(model, node, "SCALE", ElementType::kVec3);
  std::vector<Affine> instances;
  instances.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    TranslationRotationScale transform;
    if (!translations.empty()) transform.translation = translations[i];
    if (!rotations.empty()) transform.rotation = rotations[i];
    if (!scales.empty()) transform.scale = scales[i];
    instances.push_back(transform.matrix());
  }
  return instances;
}

VertexBuffer deform(const Primitive& primitive, const Rig& rig, const Pose& pose) {
  const Placement at = placement(primitive, rig, pose);
  VertexBuffer buffer(primitive.geometry->vertex_count());
  for (std::size_t vertex = 0; vertex < buffer.size(); ++vertex) buffer[vertex] = place(at, vertex);
  return buffer;
}

Vec3f deform_vertex(const Primitive& primitive, const Rig& rig, const Pose& pose, std::size_t vertex) {
  return place(placement(primitive, rig, pose), vertex);
}

}  // namespace stbvh::harness::gltf
