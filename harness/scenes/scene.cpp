#include "harness/scenes/scene.h"

#include <algorithm>
#include <cmath>

#include "harness/scenes/reach.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

void extend(Box3f& box, Vec3f p) {
  box.lower = {std::min(box.lower.x, p.x), std::min(box.lower.y, p.y), std::min(box.lower.z, p.z)};
  box.upper = {std::max(box.upper.x, p.x), std::max(box.upper.y, p.y), std::max(box.upper.z, p.z)};
}

TimeRange Mesh::motion_range() const {
  return has_step_times() ? TimeRange{step_times.front(), step_times.back()} : time_range;
}

double Mesh::step_time(std::size_t step) const {
  if (has_step_times()) return step_times[step];
  const double begin = time_range.begin;
  return begin +
         (time_range.end - begin) * (static_cast<double>(step) / static_cast<double>(segment_count()));
}

double diagonal(const Box3f& box) {
  if (!(box.lower.x <= box.upper.x)) return 0.0;
  return length(to_double(box.upper) - to_double(box.lower));
}

std::string_view problem_of(const Camera& camera) {
  const Vec3 position = to_double(camera.position), axis = to_double(camera.target) - position;
  const double side = length(cross(axis, to_double(camera.up)));
  if (!is_within_reach(position)) return "is too far away";
  if (!(camera.vertical_fov_degrees > 0 && camera.vertical_fov_degrees < 180))
    return "has a field of view that is not between 0 and 180 degrees";
  if (!(length(axis) > 0)) return "does not look anywhere";
  if (!std::isfinite(length(axis))) return "looks at what is infinitely far away";
  if (!(side > 0 && std::isfinite(side))) return "has no up, or one along its view";
  return {};
}

std::size_t Scene::triangle_count() const {
  std::size_t n = 0;
  for (const Mesh& mesh : meshes) n += mesh.triangle_count();
  return n;
}

std::size_t Scene::primitive_segment_count() const {
  std::size_t n = 0;
  for (const Mesh& mesh : meshes) n += mesh.triangle_count() * std::max<std::size_t>(mesh.segment_count(), 1);
  return n;
}

std::size_t Scene::step_count() const {
  std::size_t count = 0;
  for (const Mesh& mesh : meshes) count += mesh.steps.size();
  return count;
}

std::size_t Scene::buffer_bytes() const {
  std::size_t bytes = 0;
  for (const Mesh& mesh : meshes) {
    bytes += mesh.indices.size() * sizeof(std::uint32_t);
    for (const VertexBuffer& step : mesh.steps) bytes += step.size() * sizeof(Vec3f);
  }
  return bytes;
}

Box3f Scene::bounds() const {
  Box3f box = Box3f::empty();
  for (const Mesh& mesh : meshes) {
    for (const VertexBuffer& step : mesh.steps) {
      for (const Vec3f& p : step.span()) extend(box, p);
    }
  }
  return box;
}

Camera Scene::camera_at(double time) const {
  if (camera_steps.empty()) return camera;
  const std::size_t last = camera_steps.size() - 1;
  const double along = std::clamp(time, 0.0, 1.0) * static_cast<double>(last);
  const std::size_t step = std::min(static_cast<std::size_t>(along), last);
  const Camera &from = camera_steps[step], &to = camera_steps[std::min(step + 1, last)];
  const double f = along - static_cast<double>(step);
  const auto between = [f](Vec3f a, Vec3f b) { return to_float(lerp(to_double(a), to_double(b), f)); };
  const Camera moved{.position = between(from.position, to.position),
                     .target = between(from.target, to.target),
                     .up = between(from.up, to.up),
                     .vertical_fov_degrees = from.vertical_fov_degrees};
  return problem_of(moved).empty() ? moved : f < 0.5 ? from : to;  // half a turn in one step has no middle
}

}  // namespace stbvh::harness
