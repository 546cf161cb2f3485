#include "mesh_table.h"

#include <algorithm>
#include <map>
#include <set>

namespace stbvh {

namespace {

std::size_t bytes_of_entry(std::size_t steps, std::size_t times) {
  return sizeof(MeshRecord) + sizeof(MeshEntry) + steps * (sizeof(VertexBufferView) + sizeof(std::size_t)) +
         times * sizeof(float);
}

}  // namespace

std::vector<std::uint32_t> MeshTable::add(const BuildContext& context, const BinaryTree& tree) {
  std::vector<std::uint32_t> records;
  for (std::size_t i = 0; i < context.meshes.size(); ++i)
    records.push_back(add(context.meshes[i], context.meshlets[i], to_box3f(tree.mesh_bounds(i))));
  return records;
}

std::uint32_t MeshTable::add(const BuildMesh& mesh, const MeshletSet& meshlets, const Box3f& bounds) {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(records_.size()));
    records_.emplace_back();
    entries_.emplace_back();
  }
  const std::uint32_t number = free_.back();
  free_.pop_back();
  MeshEntry* const room = &entries_[number];
  const MeshView& view = mesh.view();
  room->steps.assign(view.steps.begin(), view.steps.end());
  room->step_times.assign(view.step_times.begin(), view.step_times.end());
  room->kept = mesh.steps_kept();
  room->steps_given = mesh.steps_given();
  room->time_range = view.time_range;
  room->deviation = mesh.deviation();
  room->is_part = mesh.is_part();
  room->is_used = true;
  room->bounds = bounds;
  room->invalid_triangles = meshlets.invalid_triangles;
  const bool is_alive = bounds.lower.x <= bounds.upper.x;
  room->triangles = is_alive ? meshlets.triangles : 0;
  room->primitive_segments = room->triangles * std::max<std::size_t>(mesh.segments(), 1);
  records_[number] = {mesh.grid(),
                      view.mask,
                      view.geom_id,
                      room->steps.data(),
                      view.indices,
                      view.index_stride,
                      room->step_times.data(),
                      mesh.index()};
  return number;
}

void MeshTable::restore(MeshEntry entry, const MeshRecord& record) {
  if (!entry.is_used) free_.push_back(static_cast<std::uint32_t>(records_.size()));
  entries_.push_back(std::move(entry));
  records_.push_back(record);
  records_.back().steps = entries_.back().steps.data();
  records_.back().step_times = entries_.back().step_times.data();
}

void MeshTable::remove(std::uint32_t record) {
  entries_[record] = {};
  records_[record] = {};
  free_.push_back(record);
}

void MeshTable::refresh(std::uint32_t record, const MeshView& view, std::size_t index) {
  MeshEntry& entry = entries_[record];
  for (std::size_t i = 0; i < entry.kept.size(); ++i) entry.steps[i] = view.steps[entry.kept[i]];
  MeshRecord& r = records_[record];
  r.mask = view.mask;
  r.geom_id = view.geom_id;
  r.indices = view.indices;
  r.index_stride = view.index_stride;
  r.index = static_cast<std::uint32_t>(index);
}

void MeshTable::enter_in(BuildStatistics& statistics) const {
  std::map<std::uint32_t, std::set<std::size_t>> kept_by_parts;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const MeshEntry& entry = entries_[i];
    if (!entry.is_used) continue;
    statistics.triangles += entry.triangles;
    statistics.invalid_triangles += entry.invalid_triangles;
    statistics.primitive_segments += entry.primitive_segments;
    statistics.max_deviation = std::max(statistics.max_deviation, entry.deviation);
    if (entry.is_part) {
      std::set<std::size_t>& kept = kept_by_parts[records_[i].index];
      if (kept.empty()) statistics.steps_given += entry.steps_given;
      kept.insert(entry.kept.begin(), entry.kept.end());
    } else {
      statistics.steps_given += entry.steps_given;
      statistics.steps_kept += entry.kept.size();
    }
  }
  for (const auto& [mesh, kept] : kept_by_parts) statistics.steps_kept += kept.size();
}

std::size_t MeshTable::bytes() const {
  std::size_t bytes = 0;
  for (const MeshEntry& entry : entries_)
    bytes += bytes_of_entry(entry.steps.size(), entry.step_times.size());
  return bytes;
}

std::size_t MeshTable::bytes_of(const std::vector<BuildMesh>& meshes) {
  std::size_t bytes = 0;
  for (const BuildMesh& mesh : meshes)
    bytes += bytes_of_entry(mesh.view().steps.size(), mesh.view().step_times.size());
  return bytes;
}

}  // namespace stbvh
