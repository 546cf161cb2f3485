#include "plugin/preload/linear_scene_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace stbvh::preload {
namespace {

constexpr std::size_t kGrain = 1 << 12;

float lerp(float a, float b, float f) {
  return (1.0f - f) * a + f * b;
}

Vec3f lerp(const Vec3f& a, const Vec3f& b, float f) {
  return {lerp(a.x, b.x, f), lerp(a.y, b.y, f), lerp(a.z, b.z, f)};
}

Box3f lerp(const Box3f& a, const Box3f& b, float f) {
  return {lerp(a.lower, b.lower, f), lerp(a.upper, b.upper, f)};
}

void add(Vec3f& a, const Vec3f& b) {
  a = {a.x + b.x, a.y + b.y, a.z + b.z};
}

/// How far `inner` sticks out of `outer` at its lower faces (<= 0) and its upper ones (>= 0).
Box3f overhang(const Box3f& inner, const Box3f& outer) {
  const auto below = [](float in, float out) { return std::min(in - out, 0.0f); };
  const auto above = [](float in, float out) { return std::max(in - out, 0.0f); };
  const Vec3f &il = inner.lower, &iu = inner.upper, &ol = outer.lower, &ou = outer.upper;
  return {{below(il.x, ol.x), below(il.y, ol.y), below(il.z, ol.z)},
          {above(iu.x, ou.x), above(iu.y, ou.y), above(iu.z, ou.z)}};
}

/// Ray times [0, 1] among the steps of a mesh.
class ShutterSteps {
 public:
  explicit ShutterSteps(const MeshView& mesh)
      : segments_(static_cast<float>(mesh.steps.size() - 1)),
        begin_((0.0f - mesh.time_range.begin) / (mesh.time_range.end - mesh.time_range.begin)),
        end_((1.0f - mesh.time_range.begin) / (mesh.time_range.end - mesh.time_range.begin)),
        first_(begin_ * segments_),
        last_(end_ * segments_) {}

  /// Whether any step or part of a segment is in them.
  bool meets() const { return last_ > 0.0f && first_ < segments_; }

  /// Bounds over [0, 1] of what has `boxes` at the steps.
  LinearBox fit(const Box3f* boxes) const {
    const float below = std::max(0.0f, std::floor(first_));
    const float above = std::min(segments_, std::ceil(last_));
    const auto low = static_cast<int>(below);
    const auto high = static_cast<int>(above);
    // Steps strictly between these stick out or not; -1 and segments + 1 stand for all that lies outside.
    const int from = static_cast<int>(std::max(-1.0f, std::floor(first_)));
    const int to = static_cast<int>(std::min(segments_ + 1.0f, std::ceil(last_)));
    const float into_first = std::max(0.0f, first_ - below);
    const float into_last = std::max(0.0f, above - last_);
    if (to - from == 1) {
      return {lerp(boxes[low], boxes[high], into_first), lerp(boxes[high], boxes[low], into_last)};
    }
    LinearBox result{lerp(boxes[low], boxes[low + 1], into_first),
                     lerp(boxes[high], boxes[high - 1], into_last)};
    for (int step = from + 1; step < to; ++step) {
      const float f = (static_cast<float>(step) / segments_ - begin_) / (end_ - begin_);
      const Box3f out = overhang(boxes[step], lerp(result.begin, result.end, f));
      for (Box3f* const box : {&result.begin, &result.end}) {
        add(box->lower, out.lower);
        add(box->upper, out.upper);
      }
    }
    return result;
  }

 private:
  float segments_;
  float begin_, end_;   ///< [0, 1] in the mesh's time range
  float first_, last_;  ///< the same in steps
};

/// Box of a triangle at each step; false if it is not valid.
bool boxes_of(const MeshView& mesh, std::size_t triangle, Box3f* boxes) {
  const TriangleIndices indices = mesh.triangle(triangle);
  for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
    Box3f box = Box3f::empty();
    for (const std::uint32_t index : indices) {
      if (index >= mesh.steps[step].count) return false;
      const Vec3f p = mesh.steps[step].position(index);
      if (!is_valid_position(p)) return false;
      box.extend(p);
    }
    boxes[step] = box;
  }
  return true;
}

LinearBox bounds_of_range(const MeshView& mesh, std::size_t begin, std::size_t end) {
  std::vector<Box3f> boxes(mesh.steps.size());
  LinearBox result;
  if (mesh.steps.size() == 1) {
    for (std::size_t i = begin; i != end; ++i) {
      if (boxes_of(mesh, i, boxes.data())) result.extend({boxes[0], boxes[0]});
    }
    return result;
  }
  const ShutterSteps steps(mesh);
  if (!steps.meets()) return result;
  for (std::size_t i = begin; i != end; ++i) {
    if (boxes_of(mesh, i, boxes.data())) result.extend(steps.fit(boxes.data()));
  }
  return result;
}

}  // namespace

void LinearBox::extend(const LinearBox& other) {
  begin.extend(other.begin);
  end.extend(other.end);
}

LinearBox linear_bounds_of(const MeshView& mesh) {
  // Of fixed blocks, so that the union does not depend on the threads (it could in the sign of a zero).
  std::vector<LinearBox> blocks((mesh.triangle_count + kGrain - 1) / kGrain);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const std::size_t end = std::min(mesh.triangle_count, (block + 1) * kGrain);
    blocks[block] = bounds_of_range(mesh, block * kGrain, end);
  });
  LinearBox result;
  for (const LinearBox& block : blocks) result.extend(block);
  return result;
}

}  // namespace stbvh::preload
