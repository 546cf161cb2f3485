/// The meshes of a structure: what the traversal reads of them, and what a change needs to know.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/binary_tree.h"
#include "builder/build_context.h"
#include "layout/layout.h"

namespace stbvh {

/// A mesh or a part of one: a record of the traversal's table.
struct MeshEntry {
  std::vector<VertexBufferView> steps;  ///< those that are kept
  std::vector<float> step_times;        ///< empty: equidistant
  std::vector<std::size_t> kept;        ///< which of the steps given
  std::size_t steps_given = 0;
  TimeRange time_range;           ///< of equidistant steps
  Box3f bounds = Box3f::empty();  ///< of its leaves
  std::size_t triangles = 0;      ///< valid, and alive at some time in [0, 1]
  std::size_t invalid_triangles = 0;
  std::size_t primitive_segments = 0;
  double deviation = 0.0;
  bool is_part = false;
  bool is_used = false;  ///< else it is room for another
};

class MeshTable {
 public:
  /// Enters the meshes of a build, whose tree there is, and returns the numbers of their records.
  std::vector<std::uint32_t> add(const BuildContext& context, const BinaryTree& tree);
  /// Enters what was saved of a mesh.
  void restore(MeshEntry entry, const MeshRecord& record);
  /// No leaf may be left that names it.
  void remove(std::uint32_t record);
  /// `view` is where the mesh stands now, `index` its number; it has the steps, the times and the triangles
  /// that it had.
  void refresh(std::uint32_t record, const MeshView& view, std::size_t index);

  std::size_t size() const { return records_.size(); }
  const MeshRecord* records() const { return records_.data(); }
  const MeshRecord& record(std::uint32_t record) const { return records_[record]; }
  MeshEntry& entry(std::uint32_t record) { return entries_[record]; }
  const MeshEntry& entry(std::uint32_t record) const { return entries_[record]; }

  /// What is known of the meshes.
  void enter_in(BuildStatistics& statistics) const;

  /// That it takes.
  std::size_t bytes() const;
  /// That it would take with these meshes alone.
  static std::size_t bytes_of(const std::vector<BuildMesh>& meshes);

 private:
  std::uint32_t add(const BuildMesh& mesh, const MeshletSet& meshlets, const Box3f& bounds);

  std::vector<MeshRecord> records_;
  std::vector<MeshEntry> entries_;
  std::vector<std::uint32_t> free_;  ///< records that no mesh uses
};

}  // namespace stbvh
