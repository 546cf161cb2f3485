#include "harness/scenes/scene_editor.h"

#include <algorithm>
#include <array>

namespace stbvh::harness {
namespace {

constexpr double kFarthest = 0.05;      ///< that a mesh moves, of the diagonal
constexpr double kDeformation = 0.003;  ///< of a mesh's own size
constexpr double kFrame = 0.1;          ///< of the motion in the shutter, that an animation goes on by

void add(Vec3f& p, const Vec3f& by) {
  p = {p.x + by.x, p.y + by.y, p.z + by.z};
}

}  // namespace

std::span<const std::string_view> edit_kind_names() {
  static constexpr std::array<std::string_view, 6> kNames{"moved",    "deformed", "animated",
                                                          "replaced", "hidden",   "masked"};
  return kNames;
}

SceneEditor::SceneEditor(Scene& scene, std::uint64_t seed)
    : scene_(scene), random_(seed, 3), diagonal_(diagonal(scene.bounds())) {
  for (const bool still : {false, true}) {
    for (std::size_t i = 0; i < scene.meshes.size() && (meshes_.empty() || !still); ++i) {
      const Mesh& mesh = scene.meshes[i];
      if (mesh.triangle_count() > 1 && (still || !mesh.is_static())) meshes_.push_back(i);
    }
  }
}

std::vector<MeshEdit> SceneEditor::apply(EditKind kind) {
  if (meshes_.empty()) return {};
  const std::size_t mesh = some_mesh();
  switch (kind) {
    case EditKind::kMoved:
      return {moved(mesh)};
    case EditKind::kDeformed:
      return {deformed(mesh)};
    case EditKind::kReplaced:
      return {replaced(mesh)};
    case EditKind::kHidden:
      return {hidden(mesh)};
    case EditKind::kMasked:
      return {masked(mesh)};
    case EditKind::kAnimated:
      break;
  }
  std::vector<MeshEdit> edits;
  for (const std::size_t i : meshes_) {
    // Each step goes on by what the vertex moves while the shutter is open; no motion is straighter for that.
    std::vector<VertexBuffer>& steps = scene_.meshes[i].steps;
    for (std::size_t v = 0; v < steps[0].size(); ++v) {
      const Vec3f first = steps.front()[v], last = steps.back()[v];
      const auto share = static_cast<float>(kFrame);
      const Vec3f by{share * (last.x - first.x), share * (last.y - first.y), share * (last.z - first.z)};
      for (VertexBuffer& step : steps) add(step[v], by);
    }
    edits.push_back({i, MeshEdit::Extent::kPositions});
  }
  return edits;
}

std::size_t SceneEditor::some_mesh() {
  const auto last = static_cast<double>(meshes_.size());
  return meshes_[std::min(static_cast<std::size_t>(random_.uniform(0.0, last)), meshes_.size() - 1)];
}

Vec3f SceneEditor::some_offset(double most) {
  const auto coordinate = [&] { return static_cast<float>(random_.uniform(-most, most)); };
  const float x = coordinate(), y = coordinate();
  return {x, y, coordinate()};
}

MeshEdit SceneEditor::moved(std::size_t mesh) {
  const Vec3f by = some_offset(kFarthest * diagonal_);
  for (VertexBuffer& step : scene_.meshes[mesh].steps) {
    for (std::size_t v = 0; v < step.size(); ++v) add(step[v], by);
  }
  return {mesh, MeshEdit::Extent::kPositions};
}

MeshEdit SceneEditor::deformed(std::size_t mesh) {
  std::vector<VertexBuffer>& steps = scene_.meshes[mesh].steps;
  Box3f box = Box3f::empty();
  for (const Vec3f& p : steps[0].span()) box.extend(p);
  const double most = kDeformation * diagonal(box);
  for (std::size_t v = 0; v < steps[0].size(); ++v) {
    const Vec3f by = some_offset(most);
    for (VertexBuffer& step : steps) add(step[v], by);
  }
  return {mesh, MeshEdit::Extent::kPositions};
}

MeshEdit SceneEditor::replaced(std::size_t mesh) {
  std::vector<std::uint32_t>& indices = scene_.meshes[mesh].indices;
  const auto given = triangles_.find(mesh);
  if (given != triangles_.end()) {
    indices = std::move(given->second);
    triangles_.erase(given);
  } else {  // every other one goes
    triangles_[mesh] = indices;
    for (std::size_t i = 0; 6 * i + 2 < indices.size(); ++i)
      std::copy_n(triangles_[mesh].begin() + static_cast<std::ptrdiff_t>(6 * i), 3,
                  indices.begin() + static_cast<std::ptrdiff_t>(3 * i));
    indices.resize(triangles_[mesh].size() / 6 * 3);
  }
  return {mesh, MeshEdit::Extent::kEverything};
}

MeshEdit SceneEditor::hidden(std::size_t mesh) {
  std::vector<std::uint32_t>& indices = scene_.meshes[mesh].indices;
  if (indices.empty()) {
    indices = std::move(triangles_.at(mesh));
    triangles_.erase(mesh);
  } else {
    triangles_.try_emplace(mesh, indices);
    indices.clear();
  }
  return {mesh, MeshEdit::Extent::kEverything};
}

MeshEdit SceneEditor::masked(std::size_t mesh) {
  std::uint32_t& mask = scene_.meshes[mesh].mask;
  mask = mask == 0 ? 0xFFFFFFFFu : 0u;
  return {mesh, MeshEdit::Extent::kMask};
}

}  // namespace stbvh::harness
