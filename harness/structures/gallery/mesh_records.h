/// What traversal and tables know of the meshes of a build.
#pragma once

#include <algorithm>
#include <vector>

#include "builder/build_context.h"
#include "harness/structures/structure_under_test.h"
#include "layout/layout.h"

namespace stbvh::harness::gallery {

/// All leaves are inline: the caller's buffers are not read.
class MeshRecords {
 public:
  MeshRecords() = default;
  explicit MeshRecords(const std::vector<BuildMesh>& meshes) {
    for (const BuildMesh& mesh : meshes) {
      const MeshView& view = mesh.view();
      step_times_.emplace_back(view.step_times.begin(), view.step_times.end());
      records_.push_back({mesh.grid(), view.mask, view.geom_id, nullptr, nullptr, 0,
                          step_times_.back().data(), mesh.index()});
    }
  }
  const MeshRecord* data() const { return records_.data(); }

 private:
  std::vector<std::vector<float>> step_times_;  ///< that the records name
  std::vector<MeshRecord> records_;
};

/// Which steps were kept, and what that costs.
inline void enter_steps(const std::vector<BuildMesh>& meshes, BuildRecord& record) {
  for (const BuildMesh& mesh : meshes) {
    record.steps_kept += mesh.steps_kept().size();
    record.max_deviation = std::max(record.max_deviation, mesh.deviation());
  }
}

}  // namespace stbvh::harness::gallery
