/// A mesh of the caller, checked once, as the builder reads it: with the steps that it needs.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "builder/build_memory.h"
#include "builder/step_reduction.h"
#include "layout/closed_time_range.h"
#include "layout/time_grid.h"
#include "stbvh/mesh_view.h"
#include "stbvh/structure.h"

namespace stbvh {

/// A part of a mesh that is built with steps of its own.
struct MeshPart {
  StepReduction steps;
  std::vector<std::uint32_t> prims;  ///< ascending
};

/// One mesh, or one part of it: access to its triangles and positions.
class BuildMesh {
 public:
  /// Keeps as few steps as stay within `tolerance` (reduce_steps()). Throws InvalidMesh, naming `index`, for
  /// a description that cannot be read.
  BuildMesh(const MeshView& view, std::size_t index, float tolerance);
  /// A part of `whole`, which was made of `view`.
  BuildMesh(const BuildMesh& whole, const MeshView& view, MeshPart part, BuildMemory& memory);
  BuildMesh(BuildMesh&&) = default;

  /// Of the whole mesh, without the steps that are left out.
  const MeshView& view() const { return view_; }
  /// Which of the caller's meshes it is.
  std::uint32_t index() const { return index_; }
  bool is_part() const { return prims_ != nullptr; }
  std::size_t triangle_count() const {
    return prims_ == nullptr ? view_.triangle_count : prims_->span().size();
  }
  /// Which triangle of the whole mesh the i-th is.
  std::uint32_t prim(std::size_t i) const {
    return prims_ == nullptr ? static_cast<std::uint32_t>(i) : prims_->data()[i];
  }
  /// Which of the steps given.
  const std::vector<std::size_t>& steps_kept() const { return kept_; }
  std::size_t steps_given() const { return steps_given_; }
  /// How far the motion is off without them, at most; scene units.
  double deviation() const { return deviation_; }
  const TimeGrid& grid() const { return grid_; }
  std::size_t segments() const { return view_.steps.size() - 1; }
  bool is_static() const { return view_.steps.size() == 1; }

  TriangleIndices triangle(std::size_t prim) const { return view_.triangle(prim); }
  Vec3f position(std::size_t step, std::uint32_t vertex) const { return view_.steps[step].position(vertex); }

  /// Which segment a time belongs to: what the traversal finds. Not for static meshes.
  SegmentTime segment_at(float time) const;
  /// In exact arithmetic.
  double time_of_step(std::size_t step) const;
  /// Bounds the rounding of a segment's fraction, in units of 2^-22 (docs/accuracy.md).
  float fraction_rounding() const { return grid_.is_uneven() ? 1.0f : grid_.segments; }
  /// How fine the steps are: of equidistant ones everywhere the same, of others in `range`. 0: static.
  float segments_per_time(const ClosedTimeRange& range) const;

  /// Whether all indices are in range and all positions valid, in every step.
  bool is_valid(const TriangleIndices& triangle) const;
  bool has_invalid_vertices() const { return !invalid_vertices_.empty(); }
  bool is_invalid(std::size_t vertex) const {
    return !invalid_vertices_.empty() && invalid_vertices_[vertex];
  }

  /// First and last segment met by the times of `range`, which overlaps the mesh's own. Not for static
  /// meshes.
  struct SegmentRange {
    std::uint32_t first, last;
  };
  SegmentRange segments_in(const ClosedTimeRange& range) const;

  /// Steps that an inline leaf over `range` holds; 0: the mesh is not alive then.
  std::size_t steps_in(const ClosedTimeRange& range) const;

  /// The step boundary inside `range` that is nearest to its centre: the first time of a segment other than
  /// the first one met. None where one segment covers the range.
  std::optional<float> central_boundary(const ClosedTimeRange& range) const;

  /// `range` cut to the times at which the mesh is alive; begin > last if there is none.
  ClosedTimeRange alive(const ClosedTimeRange& range) const;

 private:
  BuildMesh(const MeshView& view, std::size_t index);
  void find_invalid_vertices();
  void keep(StepReduction reduction);
  void make_grid();

  MeshView view_;
  std::vector<VertexBufferView> steps_;  ///< of view_, where some were left out
  std::vector<float> times_;             ///< of view_, where the steps are uneven; no denormals
  std::uint32_t index_;
  std::unique_ptr<TemporaryArray<std::uint32_t>> prims_;  ///< null: all
  std::size_t steps_given_;
  std::vector<std::size_t> kept_;
  double deviation_ = 0.0;
  TimeGrid grid_;
  std::vector<float> boundaries_;       ///< first_time_of_segment of segments 1 to S - 1
  std::vector<bool> invalid_vertices_;  ///< empty: all are valid
};

/// Of steps over their times, or equidistant over their time range; of one, static.
TimeGrid time_grid_of(const MeshView& view);

/// The smallest float t with segment_at(grid, t) >= segment, for 0 < segment < S.
float first_time_of_segment(const TimeGrid& grid, std::uint32_t segment);

}  // namespace stbvh
