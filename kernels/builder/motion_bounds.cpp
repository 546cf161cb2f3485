#include "builder/motion_bounds.h"

#include <algorithm>

#include "builder/tightest_bounds.h"

namespace stbvh {

MotionSamples::MotionSamples(const BuildMesh& mesh, const ClosedTimeRange& range) {
  if (mesh.is_static()) {
    samples[0] = {0.0f, 0.0f, 0};
    count = 1;
    return;
  }
  const ClosedTimeRange alive = mesh.alive(range);
  if (!(alive.begin <= alive.last)) return;
  covers_range = alive == range;
  const TimeGrid& grid = mesh.grid();
  const SegmentTime first = segment_at(grid, alive.begin);
  const SegmentTime last = segment_at(grid, alive.last);
  const double length = static_cast<double>(alive.last) - alive.begin;
  samples[count++] = {0.0f, first.fraction, first.segment};
  for (std::uint32_t step = first.segment + 1; step <= last.segment; ++step) {
    const double time = grid.begin + (static_cast<double>(grid.end) - grid.begin) * step / grid.segments;
    const double parameter = length > 0 ? (time - alive.begin) / length : 0.0;
    samples[count++] = {static_cast<float>(std::clamp(parameter, 0.0, 1.0)), 0.0f, step};
  }
  if (length > 0) samples[count++] = {1.0f, last.fraction, last.segment};
}

namespace {

/// Boxes of the given vertices at all samples.
void sample_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                   std::span<const std::uint32_t> vertices, std::span<BoundsSample> boxes) {
  F32x4 pad(0.0f);
  for (std::size_t i = 0; i < samples.count; ++i) {
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
    pad = max(pad, F32x4(0x1p-20f * mesh.grid().segments) * motion + F32x4(0x1p-20f) * largest);
  }
  if (mesh.is_static()) return;
  for (auto& [parameter, box] : boxes.first(samples.count)) {
    box = {box.lower - pad, box.upper + pad};
  }
}

}  // namespace

LinearBounds motion_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                           std::span<const std::uint32_t> vertices) {
  std::array<BoundsSample, kMaxSteps + 2> boxes;
  sample_bounds(mesh, samples, vertices, boxes);
  const std::span<const BoundsSample> used(boxes.data(), samples.count);
  if (samples.count > 1 && samples.covers_range) return tightest_at_centre(used);
  Box4 all = Box4::empty();
  for (const BoundsSample& sample : used) all.extend(sample.box);
  return {all, all};
}

}  // namespace stbvh
