#include "harness/scenes/resampled.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/pcg32.h"

namespace stbvh::harness {
namespace {

VertexBuffer mixed(const VertexBuffer& a, const VertexBuffer& b, double f) {
  VertexBuffer result(a.size());
  const auto mix = [f](float x, float y) { return static_cast<float>((1 - f) * x + f * y); };
  for (std::size_t v = 0; v < a.size(); ++v)
    result[v] = {mix(a[v].x, b[v].x), mix(a[v].y, b[v].y), mix(a[v].z, b[v].z)};
  return result;
}

/// The motion at a step's time: at an old step, nothing rounds.
VertexBuffer at_time(const Mesh& mesh, float time) {
  const MotionSample sample = motion_sample(mesh, time);
  return mixed(mesh.steps[sample.segment], mesh.steps[std::min(sample.segment + 1, mesh.segment_count())],
               sample.fraction);
}

/// Each up to two fifths of an equidistant step off its place, the ends where they are; fewer where floats
/// are too far apart.
std::vector<float> uneven_times(TimeRange range, std::size_t steps) {
  const double begin = range.begin, length = range.end - begin, segments = static_cast<double>(steps - 1);
  Pcg32 random(1);
  std::vector<float> times{range.begin};
  for (std::size_t i = 1; i + 1 < steps; ++i) {
    const double place = static_cast<double>(i) + random.uniform(-0.4, 0.4);
    const auto time = static_cast<float>(begin + length * (place / segments));
    if (time > times.back() && time < range.end) times.push_back(time);
  }
  times.push_back(range.end);
  return times;
}

void resample_unevenly(Mesh& mesh, std::size_t steps) {
  const std::vector<float> times = uneven_times(mesh.motion_range(), steps);
  std::vector<VertexBuffer> result;
  for (const float time : times) result.push_back(at_time(mesh, time));
  mesh.steps = std::move(result);
  mesh.step_times = times;
}

void resample(Mesh& mesh, std::size_t steps) {
  const std::size_t segments = mesh.segment_count();
  std::vector<VertexBuffer> result;
  for (std::size_t i = 0; i < steps; ++i) {
    if (mesh.has_step_times()) {
      const TimeRange range = mesh.motion_range();
      const double f = static_cast<double>(i) / static_cast<double>(steps - 1);
      result.push_back(at_time(mesh, static_cast<float>((1 - f) * range.begin + f * range.end)));
      continue;
    }
    // As a ratio of integers: where a new step is an old one, nothing rounds.
    const std::size_t numerator = i * segments, denominator = steps - 1;
    const std::size_t k = std::min(numerator / denominator, std::max<std::size_t>(segments, 1) - 1);
    const double f = static_cast<double>(numerator - k * denominator) / static_cast<double>(denominator);
    result.push_back(mixed(mesh.steps[k], mesh.steps[std::min(k + 1, segments)], f));
  }
  mesh.steps = std::move(result);
  mesh.time_range = mesh.motion_range();
  mesh.step_times.clear();
}

}  // namespace

Scene resampled(Scene scene, std::size_t steps, StepPlaces places) {
  tbb::parallel_for(std::size_t{0}, scene.meshes.size(), [&](std::size_t i) {
    Mesh& mesh = scene.meshes[i];
    if (mesh.is_static()) mesh.time_range = {};  // which is not looked at yet
    places == StepPlaces::kUneven ? resample_unevenly(mesh, steps) : resample(mesh, steps);
  });
  return scene;
}

}  // namespace stbvh::harness
