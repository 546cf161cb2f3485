#include "harness/scenes/finite_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "harness/scenes/cancellation.h"

namespace stbvh::harness {

namespace {

constexpr std::size_t kMostNamedMeshes = 5;
constexpr std::uint32_t kLeftOut = std::numeric_limits<std::uint32_t>::max();

bool is_valid(const Mesh& mesh) {
  return std::all_of(mesh.steps.begin(), mesh.steps.end(), [](const VertexBuffer& step) {
    return std::all_of(step.span().begin(), step.span().end(), is_valid_position);
  });
}

/// The new index of each vertex, kLeftOut for those that are invalid in any step; and how many are left.
std::pair<std::vector<std::uint32_t>, std::size_t> renumbered(const Mesh& mesh) {
  std::vector<std::uint32_t> numbers(mesh.steps.front().size(), 0);
  for (const VertexBuffer& step : mesh.steps) {
    for (std::size_t v = 0; v < step.size(); ++v) {
      if (!is_valid_position(step[v])) numbers[v] = kLeftOut;
    }
  }
  std::uint32_t count = 0;
  for (std::uint32_t& number : numbers) {
    if (number != kLeftOut) number = count++;
  }
  return {std::move(numbers), count};
}

void keep_valid(Mesh& mesh) {
  const auto [numbers, count] = renumbered(mesh);
  for (VertexBuffer& step : mesh.steps) {
    VertexBuffer kept(count);
    for (std::size_t v = 0; v < step.size(); ++v) {
      if (numbers[v] != kLeftOut) kept[numbers[v]] = step[v];
    }
    step = std::move(kept);
  }
  std::vector<std::uint32_t> indices, faces;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::uint32_t a = numbers[mesh.indices[i]], b = numbers[mesh.indices[i + 1]],
                        c = numbers[mesh.indices[i + 2]];
    if (a == kLeftOut || b == kLeftOut || c == kLeftOut) continue;
    indices.insert(indices.end(), {a, b, c});
    faces.push_back(mesh.face_of(static_cast<std::uint32_t>(i / 3)));
  }
  mesh.faces = std::move(faces);
  mesh.indices = std::move(indices);
}

}  // namespace

void leave_out_invalid_triangles(Scene& scene, const std::filesystem::path& file, const SceneWarning& warn) {
  std::vector<std::size_t> before;
  for (const Mesh& mesh : scene.meshes) before.push_back(mesh.triangle_count());
  for_all(scene.meshes.size(), [&](std::size_t m) {
    if (!is_valid(scene.meshes[m])) keep_valid(scene.meshes[m]);
  });
  std::string list;
  std::size_t triangles = 0, meshes = 0;
  for (std::size_t m = 0; m < before.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const std::size_t lost = before[m] - mesh.triangle_count();
    if (lost == 0) continue;
    triangles += lost;
    if (++meshes <= kMostNamedMeshes)
      list += fmt::format("{}{} of {} in \"{}\"", list.empty() ? "" : ", ", lost, before[m], mesh.name);
  }
  if (triangles == 0) return;
  std::size_t m = 0;
  std::erase_if(scene.meshes,
                [&](const Mesh& mesh) { return before[m++] > 0 && mesh.triangle_count() == 0; });
  if (meshes > kMostNamedMeshes) list += fmt::format(", the rest in {} more", meshes - kMostNamedMeshes);
  if (warn)
    warn(fmt::format("{}: {} triangle{} left out, with vertices that are not finite or too far away: {}",
                     file.string(), triangles, triangles == 1 ? " is" : "s are", list));
}

}  // namespace stbvh::harness
