#include "builder/reference.h"

#include <algorithm>
#include <cstring>

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

void sample_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                   std::span<const std::uint32_t> vertices, std::span<BoundsSample> boxes) {
  F32x4 pad(0.0f);
  for (std::size_t i = 0; i < samples.count; ++i) {
    const MotionSamples::Sample& sample = samples.samples[i];
    F32x4 lower(std::numeric_limits<float>::infinity());
    F32x4 upper(-std::numeric_limits<float>::infinity());
    F32x4 motion(0.0f);
    for (const std::uint32_t vertex : vertices) {
      F32x4 p(mesh.position(sample.segment, vertex));
      if (!mesh.is_static()) {
        const F32x4 next(mesh.position(sample.segment + 1, vertex));
        motion = max(motion, abs(next - p));
        p = F32x4(1.0f - sample.fraction) * p + F32x4(sample.fraction) * next;
      }
      lower = min(lower, p);
      upper = max(upper, p);
    }
    boxes[i] = {sample.parameter, lower, upper};
    const F32x4 largest = max(abs(lower), abs(upper)) + motion;
    pad = max(pad, F32x4(0x1p-20f * mesh.grid().segments) * motion + F32x4(0x1p-20f) * largest);
  }
  if (mesh.is_static()) return;
  for (BoundsSample& box : boxes.first(samples.count)) {
    box.lower = box.lower - pad;
    box.upper = box.upper + pad;
  }
}

LinearBounds motion_bounds(const BuildMesh& mesh, const MotionSamples& samples,
                           std::span<const std::uint32_t> vertices) {
  std::array<BoundsSample, kMaxSteps + 2> boxes;
  sample_bounds(mesh, samples, vertices, boxes);
  const std::span<const BoundsSample> used(boxes.data(), samples.count);
  if (samples.count > 1 && samples.covers_range) return tightest_at_centre(used);
  BoundsSample all = used[0];
  for (const BoundsSample& box : used) {
    all.lower = min(all.lower, box.lower);
    all.upper = max(all.upper, box.upper);
  }
  return {all.lower, all.upper, all.lower, all.upper};
}

Reference make_reference(const LinearBounds& bounds, std::uint32_t mesh, std::uint32_t meshlet) {
  Reference r;
  _mm_storeu_ps(r.lower_begin, bounds.lower_begin.v);
  _mm_storeu_ps(r.upper_begin, bounds.upper_begin.v);
  _mm_storeu_ps(r.lower_end, bounds.lower_end.v);
  _mm_storeu_ps(r.upper_end, bounds.upper_end.v);
  r.meshlet = meshlet;
  r.mesh = mesh;
  return r;
}

}  // namespace stbvh
