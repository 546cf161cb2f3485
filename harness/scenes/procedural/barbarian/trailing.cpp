#include "harness/scenes/procedural/barbarian/trailing.h"

#include <algorithm>

#include "harness/scenes/cancellation.h"

namespace stbvh::harness {
namespace {

/// Number of past poses between which a vertex is interpolated.
constexpr std::size_t kPastPoses = 12;

}  // namespace

void add_lock(TrailingShape& hair, const std::vector<Vec3>& path, double radius, std::size_t around,
              std::size_t joint, double tip_lag) {
  std::vector<TubeSection> sections;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(path.size() - 1);
    const double r = radius * std::sqrt(1.02 - s) * (0.6 + 0.4 * std::sin(kPi * std::min(1.0, s + 0.3)));
    sections.push_back({path[i], r, 0.6 * r});
  }
  const Vec3 chord = normalize(path.back() - path.front());
  hair.skinned.append(SkinnedShape::rigid(make_tube(sections, around, perpendicular(chord)), joint));
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(path.size() - 1);
    hair.lag.insert(hair.lag.end(), around, tip_lag * s * s);
  }
}

Mesh trail(std::string name, const TrailingShape& shape, const Skeleton& skeleton, const PoseAt& pose,
           std::size_t steps, Vec3f color) {
  const double longest = *std::max_element(shape.lag.begin(), shape.lag.end());
  const double spacing = std::max(longest, 1e-9) / static_cast<double>(kPastPoses - 1);
  Mesh mesh;
  mesh.name = std::move(name);
  mesh.indices = shape.skinned.shape.indices;
  mesh.material.color = color;
  const std::vector<Vec3>& rest = shape.skinned.shape.positions;
  for (std::size_t k = 0; k < steps; ++k) {
    std::vector<std::vector<Rigid>> past;
    for (std::size_t i = 0; i <= kPastPoses; ++i)
      past.push_back(skin_transforms(skeleton, pose(step_time(k, steps) - spacing * static_cast<double>(i))));
    VertexBuffer& buffer = mesh.steps.emplace_back(rest.size());
    for_all(rest.size(), [&](std::size_t i) {
      const double back = shape.lag[i] / spacing;
      const auto whole = static_cast<std::size_t>(back);
      const SkinWeights& weights = shape.skinned.weights[i];
      buffer[i] = to_float(lerp(skin_point(rest[i], weights, past[whole]),
                                skin_point(rest[i], weights, past[whole + 1]), back - std::floor(back)));
    });
  }
  return mesh;
}

}  // namespace stbvh::harness
