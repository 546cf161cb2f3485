#include "harness/scenes/resampled.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace stbvh::harness {
namespace {

VertexBuffer mixed(const VertexBuffer& a, const VertexBuffer& b, double f) {
  VertexBuffer result(a.size());
  const auto mix = [f](float x, float y) { return static_cast<float>((1 - f) * x + f * y); };
  for (std::size_t v = 0; v < a.size(); ++v)
    result[v] = {mix(a[v].x, b[v].x), mix(a[v].y, b[v].y), mix(a[v].z, b[v].z)};
  return result;
}

void resample(Mesh& mesh, std::size_t steps) {
  const std::size_t segments = mesh.segment_count();
  std::vector<VertexBuffer> result;
  for (std::size_t i = 0; i < steps; ++i) {
    // As a ratio of integers: where a new step is an old one, nothing rounds.
    const std::size_t numerator = i * segments, denominator = steps - 1;
    const std::size_t k = std::min(numerator / denominator, std::max<std::size_t>(segments, 1) - 1);
    const double f = static_cast<double>(numerator - k * denominator) / static_cast<double>(denominator);
    result.push_back(mixed(mesh.steps[k], mesh.steps[std::min(k + 1, segments)], f));
  }
  mesh.steps = std::move(result);
}

}  // namespace

Scene resampled(Scene scene, std::size_t steps) {
  tbb::parallel_for(std::size_t{0}, scene.meshes.size(), [&](std::size_t i) {
    Mesh& mesh = scene.meshes[i];
    if (mesh.is_static()) mesh.time_range = {};  // which is not looked at yet
    resample(mesh, steps);
  });
  return scene;
}

}  // namespace stbvh::harness
