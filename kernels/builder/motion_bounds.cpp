#include "builder/motion_bounds.h"

#include <algorithm>

#include "builder/sample_array.h"

namespace stbvh {

MotionSamples::MotionSamples(const BuildMesh& mesh, const ClosedTimeRange& range) {
  if (mesh.is_static()) {
    samples = {{0.0f, 0.0f, 0}};
    return;
  }
  const ClosedTimeRange alive = mesh.alive(range);
  if (!(alive.begin <= alive.last)) return;
  covers_range = alive == range;
  const SegmentTime first = mesh.segment_at(alive.begin);
  const SegmentTime last = mesh.segment_at(alive.last);
  const double length = static_cast<double>(alive.last) - alive.begin;
  samples.reserve(last.segment - first.segment + 2);
  samples.push_back({0.0f, first.fraction, first.segment});
  for (std::uint32_t step = first.segment + 1; step <= last.segment; ++step) {
    const double parameter = length > 0 ? (mesh.time_of_step(step) - alive.begin) / length : 0.0;
    samples.push_back({static_cast<float>(std::clamp(parameter, 0.0, 1.0)), 0.0f, step});
  }
  if (length > 0) samples.push_back({1.0f, last.fraction, last.segment});
}

void sample_boxes(const BuildMesh& mesh, const MotionSamples& samples,
                  std::span<const std::uint32_t> vertices, std::span<BoundsSample> boxes) {
  F32x4 pad(0.0f);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const MotionSamples::Sample& sample = samples.samples[i];
    Box4 box = Box4::empty();
    F32x4 motion(0.0f);
    for (const std::uint32_t vertex : vertices) {
      F32x4 p(mesh.position(sample.segment, vertex));
      if (!mesh.is_static()) {
        const F32x4 next(mesh.position(sample.segment + 1, vertex));
        motion = max(motion, abs(next - p));
        p = F32x4(1.0f - sample.fraction) * p + F32x4(sample.fraction) * next;
      }
      box.extend(p);
    }
    boxes[i] = {sample.parameter, box};
    const F32x4 largest = max(abs(box.lower), abs(box.upper)) + motion;
    pad = max(pad, F32x4(0x1p-20f * mesh.fraction_rounding()) * motion + F32x4(0x1p-20f) * largest);
  }
  if (mesh.is_static()) return;
  for (auto& [parameter, box] : boxes) {
    box = {box.lower - pad, box.upper + pad};
  }
}

LinearBounds motion_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                           std::span<const std::uint32_t> vertices) {
  SampleArray<BoundsSample> boxes(samples.samples.size());
  const std::span<BoundsSample> used(boxes.data(), samples.samples.size());
  sample_boxes(mesh, samples, vertices, used);
  if (used.size() > 1 && samples.covers_range) return tightest_at_centre(used);
  Box4 all = Box4::empty();
  for (const BoundsSample& sample : used) all.extend(sample.box);
  return {all, all};
}

}  // namespace stbvh
