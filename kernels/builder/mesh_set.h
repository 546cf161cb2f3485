/// The caller's meshes, checked once, as the builder reads them.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "layout/time_grid.h"
#include "stbvh/mesh_view.h"
#include "stbvh/structure.h"

namespace stbvh {

/// Closed range of float times; the next range begins at the next float.
struct ClosedTimeRange {
  float begin;
  float last;

  bool operator==(const ClosedTimeRange&) const = default;
};

/// One mesh: access to its triangles and positions.
class BuildMesh {
 public:
  /// Throws InvalidMesh, naming `index`, for a description that cannot be read.
  BuildMesh(const MeshView& view, std::size_t index);

  const MeshView& view() const { return view_; }
  const TimeGrid& grid() const { return grid_; }
  std::size_t segments() const { return view_.steps.size() - 1; }
  bool is_static() const { return view_.steps.size() == 1; }

  struct Triangle {
    std::uint32_t vertex[3];
  };
  Triangle triangle(std::size_t prim) const {
    Triangle t;
    std::memcpy(&t, static_cast<const char*>(view_.indices) + prim * view_.index_stride, sizeof t);
    return t;
  }
  Vec3f position(std::size_t step, std::uint32_t vertex) const {
    const VertexBufferView& buffer = view_.steps[step];
    Vec3f p;
    std::memcpy(&p, static_cast<const char*>(buffer.data) + vertex * buffer.stride, sizeof p);
    return p;
  }

  /// Whether all indices are in range and all positions finite and below kMaxCoordinate, in every step.
  bool is_valid(const Triangle& triangle) const;

  /// First and last segment met by the times of `range`, which overlaps the mesh's own. Not for static
  /// meshes.
  struct SegmentRange {
    std::uint32_t first, last;
  };
  SegmentRange segments_in(const ClosedTimeRange& range) const;

  /// The step boundary inside `range` that is nearest to its centre: the first time of a segment other than
  /// the first one met. None where one segment covers the range.
  std::optional<float> central_boundary(const ClosedTimeRange& range) const;

  /// `range` cut to the times at which the mesh is alive; begin > last if there is none.
  ClosedTimeRange alive(const ClosedTimeRange& range) const;

 private:
  void find_invalid_vertices();

  MeshView view_;
  TimeGrid grid_;
  std::vector<float> boundaries_;       ///< first_time_of_segment of segments 1 to S - 1
  std::vector<bool> invalid_vertices_;  ///< empty: all are valid
};

/// The smallest float t with segment_at(grid, t) >= segment, for 0 < segment < S.
float first_time_of_segment(const TimeGrid& grid, std::uint32_t segment);

}  // namespace stbvh
