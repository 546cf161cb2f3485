#include "harness/scenes/procedural/shared/skeleton.h"

#include "harness/scenes/cancellation.h"

namespace stbvh::harness {

std::size_t Skeleton::add(std::size_t parent, Vec3 position) {
  parents.push_back(parent);
  rest.push_back(position);
  return rest.size() - 1;
}

std::vector<Rigid> skin_transforms(const Skeleton& skeleton, const Pose& pose) {
  std::vector<Rigid> frames(skeleton.rest.size());
  std::vector<Rigid> result(skeleton.rest.size());
  for (std::size_t j = 0; j < frames.size(); ++j) {
    const std::size_t parent = skeleton.parents[j];
    const Rigid turn{pose.turns[j], {}};
    frames[j] = parent == kNoJoint
                    ? pose.root * translation(skeleton.rest[j]) * turn
                    : frames[parent] * translation(skeleton.rest[j] - skeleton.rest[parent]) * turn;
    result[j] = frames[j] * translation(-skeleton.rest[j]);
  }
  return result;
}

std::vector<std::vector<Rigid>> transforms_over_steps(const Skeleton& skeleton, const PoseAt& pose,
                                                      std::size_t steps) {
  std::vector<std::vector<Rigid>> result;
  for (std::size_t k = 0; k < steps; ++k)
    result.push_back(skin_transforms(skeleton, pose(step_time(k, steps))));
  return result;
}

SkinnedShape SkinnedShape::from(const ImplicitBody& body, const Skeleton& skeleton, std::size_t triangles) {
  SkinnedShape result;
  result.shape = polygonise_to_count(body, triangles);
  const std::vector<Vec3>& positions = result.shape.positions;
  result.weights.resize(positions.size());
  for_all(positions.size(),
          [&](std::size_t i) { result.weights[i] = body.weights(positions[i], skeleton.parents); });
  return result;
}

SkinnedShape SkinnedShape::rigid(const Shape& shape, std::size_t joint) {
  SkinWeights weights;
  weights.joints[0] = static_cast<std::uint32_t>(joint);
  weights.weights[0] = 1;
  return {shape, std::vector<SkinWeights>(shape.positions.size(), weights)};
}

void SkinnedShape::append(const SkinnedShape& other) {
  shape.append(other.shape);
  weights.insert(weights.end(), other.weights.begin(), other.weights.end());
}

SkinnedShape SkinnedShape::select(const std::function<bool(Vec3)>& choose) const {
  constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
  std::vector<std::uint32_t> renumbered(shape.positions.size(), kUnused);
  SkinnedShape result;
  for (std::size_t t = 0; t < shape.indices.size(); t += 3) {
    Vec3 centroid;
    for (std::size_t k = 0; k < 3; ++k)
      centroid = centroid + shape.positions[shape.indices[t + k]] * (1.0 / 3);
    if (!choose(centroid)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = shape.indices[t + k];
      if (renumbered[v] == kUnused) {
        renumbered[v] = static_cast<std::uint32_t>(result.shape.positions.size());
        result.shape.positions.push_back(shape.positions[v]);
        result.weights.push_back(weights[v]);
      }
      result.shape.indices.push_back(renumbered[v]);
    }
  }
  return result;
}

Vec3 skin_point(Vec3 p, const SkinWeights& weights, const std::vector<Rigid>& transforms) {
  Vec3 sum;
  for (std::size_t k = 0; k < weights.joints.size(); ++k) {
    if (weights.weights[k] > 0) sum = sum + transforms[weights.joints[k]].apply(p) * weights.weights[k];
  }
  return sum;
}

Mesh skin(std::string name, const SkinnedShape& skinned, const std::vector<std::vector<Rigid>>& transforms,
          Vec3f color) {
  Mesh mesh;
  mesh.name = std::move(name);
  mesh.indices = skinned.shape.indices;
  mesh.material.color = color;
  const std::vector<Vec3>& rest = skinned.shape.positions;
  mesh.steps = make_steps(rest.size(), transforms.size(), [&](std::size_t i, std::size_t k) {
    return skin_point(rest[i], skinned.weights[i], transforms[k]);
  });
  return mesh;
}

}  // namespace stbvh::harness
