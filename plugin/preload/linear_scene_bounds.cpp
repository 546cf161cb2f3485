#include "plugin/preload/linear_scene_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "simd/box4.h"

namespace stbvh::preload {
namespace {

constexpr std::size_t kGrain = 1 << 12;

/// As LinearBox, in registers.
struct LinearBox4 {
  Box4 begin = Box4::empty();
  Box4 end = Box4::empty();

  void extend(const LinearBox4& other) {
    begin.extend(other.begin);
    end.extend(other.end);
  }
};

Box4 lerp(const Box4& a, const Box4& b, float f) {
  const F32x4 of_a(1.0f - f), of_b(f);
  return {of_a * a.lower + of_b * b.lower, of_a * a.upper + of_b * b.upper};
}

/// How far `inner` sticks out of `outer` at its lower faces (<= 0) and its upper ones (>= 0).
Box4 overhang(const Box4& inner, const Box4& outer) {
  return {min(inner.lower - outer.lower, F32x4(0.0f)), max(inner.upper - outer.upper, F32x4(0.0f))};
}

void add(Box4& box, const Box4& faces) {
  box = {box.lower + faces.lower, box.upper + faces.upper};
}

/// Ray times [0, 1] among the steps of a mesh.
class ShutterSteps {
 public:
  explicit ShutterSteps(const MeshView& mesh) {
    const auto segments = static_cast<float>(mesh.steps.size() - 1);
    // [0, 1] in the mesh's time range, and the same in steps.
    const float begin = (0.0f - mesh.time_range.begin) / (mesh.time_range.end - mesh.time_range.begin);
    const float end = (1.0f - mesh.time_range.begin) / (mesh.time_range.end - mesh.time_range.begin);
    const float first = begin * segments, last = end * segments;
    meets_ = last > 0.0f && first < segments;
    if (!meets_) return;
    const float below = std::max(0.0f, std::floor(first));
    const float above = std::min(segments, std::ceil(last));
    low_ = static_cast<std::size_t>(below);
    high_ = static_cast<std::size_t>(above);
    into_first_ = std::max(0.0f, first - below);
    into_last_ = std::max(0.0f, above - last);
    // Steps strictly between these stick out or not; -1 and segments + 1 stand for all that lies outside.
    const int from = static_cast<int>(std::max(-1.0f, std::floor(first)));
    const int to = static_cast<int>(std::min(segments + 1.0f, std::ceil(last)));
    is_in_one_segment_ = to - from == 1;
    if (is_in_one_segment_) return;
    for (int step = from + 1; step < to; ++step) {
      const float f = (static_cast<float>(step) / segments - begin) / (end - begin);
      between_.push_back({static_cast<std::size_t>(step), f});
    }
  }

  /// Whether any step or part of a segment is in them.
  bool meets() const { return meets_; }

  /// Bounds over [0, 1] of what has `boxes` at the steps.
  LinearBox4 fit(const Box4* boxes) const {
    if (is_in_one_segment_) {
      return {lerp(boxes[low_], boxes[high_], into_first_), lerp(boxes[high_], boxes[low_], into_last_)};
    }
    LinearBox4 result{lerp(boxes[low_], boxes[low_ + 1], into_first_),
                      lerp(boxes[high_], boxes[high_ - 1], into_last_)};
    for (const Between& between : between_) {
      const Box4 out = overhang(boxes[between.step], lerp(result.begin, result.end, between.fraction));
      add(result.begin, out);
      add(result.end, out);
    }
    return result;
  }

 private:
  struct Between {
    std::size_t step;
    float fraction;  ///< of [0, 1]
  };

  bool meets_;
  bool is_in_one_segment_ = false;
  std::size_t low_ = 0, high_ = 0;
  float into_first_ = 0.0f, into_last_ = 0.0f;
  std::vector<Between> between_;
};

/// The triangles of a mesh, their vertices in registers.
class Triangles {
 public:
  explicit Triangles(const MeshView& mesh) : mesh_(mesh), vertices_(mesh.steps[0].count) {
    for (const VertexBufferView& step : mesh.steps) vertices_ = std::min(vertices_, step.count);
  }

  /// Box of a triangle at each step; false if it is not valid.
  bool boxes_of(std::size_t triangle, Box4* boxes) const {
    const TriangleIndices indices = mesh_.triangle(triangle);
    if (std::max({indices[0], indices[1], indices[2]}) >= vertices_) return false;
    for (const VertexBufferView& step : mesh_.steps) {
      const F32x4 a(step.position(indices[0])), b(step.position(indices[1])), c(step.position(indices[2]));
      if (!is_valid(a) || !is_valid(b) || !is_valid(c)) return false;
      *boxes++ = {min(min(a, b), c), max(max(a, b), c)};
    }
    return true;
  }

 private:
  /// As is_valid_position().
  static bool is_valid(F32x4 position) { return below3(abs(position), F32x4(kMaxCoordinate)); }

  const MeshView& mesh_;
  std::size_t vertices_;  ///< that there are at all steps
};

LinearBox4 bounds_of_range(const MeshView& mesh, std::size_t begin, std::size_t end) {
  const Triangles triangles(mesh);
  std::vector<Box4> boxes(mesh.steps.size());
  LinearBox4 result;
  if (mesh.steps.size() == 1) {
    for (std::size_t i = begin; i != end; ++i) {
      if (triangles.boxes_of(i, boxes.data())) result.extend({boxes[0], boxes[0]});
    }
    return result;
  }
  const ShutterSteps steps(mesh);
  if (!steps.meets()) return result;
  for (std::size_t i = begin; i != end; ++i) {
    if (triangles.boxes_of(i, boxes.data())) result.extend(steps.fit(boxes.data()));
  }
  return result;
}

}  // namespace

void LinearBox::extend(const LinearBox& other) {
  begin.extend(other.begin);
  end.extend(other.end);
}

std::vector<LinearBox> linear_bounds_of(std::span<const MeshView* const> meshes) {
  // Of fixed blocks, so that the union does not depend on the threads (it could in the sign of a zero).
  struct Block {
    std::size_t mesh;
    std::size_t begin;
    LinearBox4 bounds{};
  };
  std::vector<Block> blocks;
  for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
    for (std::size_t i = 0; i < meshes[mesh]->triangle_count; i += kGrain) blocks.push_back({mesh, i});
  }
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    Block& block = blocks[i];
    const MeshView& mesh = *meshes[block.mesh];
    block.bounds = bounds_of_range(mesh, block.begin, std::min(mesh.triangle_count, block.begin + kGrain));
  });
  std::vector<LinearBox> result(meshes.size());
  for (const auto& [mesh, begin, bounds] : blocks)
    result[mesh].extend({to_box3f(bounds.begin), to_box3f(bounds.end)});
  return result;
}

}  // namespace stbvh::preload
