#include "ray_bytes.h"

#include <algorithm>
#include <array>

#include "builder/step_reduction.h"

namespace stbvh::fuzz {

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

float take_time(ByteReader& in, const MeshView& mesh) {
  const std::uint8_t code = in.byte();
  if (code >= 0xF8) return in.number();
  const float share = static_cast<float>(in.byte()) / 255.0f;
  TimeRange range = mesh.time_range;
  if (!mesh.step_times.empty()) range = {mesh.step_times.front(), mesh.step_times.back()};
  const float begin = std::clamp(range.begin, 0.0f, 1.0f), end = std::clamp(range.end, 0.0f, 1.0f);
  if (code < 0x60 || mesh.steps.size() == 1) return begin + share * (end - begin);
  const auto segments = static_cast<double>(mesh.steps.size() - 1);
  const double step = std::floor(share * segments + 0.5);
  float time = step_time(mesh, static_cast<std::size_t>(step));
  if (code % 4 == 1) time = std::nextafter(time, kInf);
  if (code % 4 == 2) time = std::nextafter(time, -kInf);
  return std::clamp(time, 0.0f, 1.0f);
}

std::array<double, 3> corner_at(const MeshView& mesh, std::uint32_t vertex, float time) {
  std::array<double, 3> p{};
  if (vertex >= mesh.steps[0].count) return p;
  const std::size_t segments = mesh.steps.size() - 1;
  std::size_t k = 0;
  double f = 0;
  if (segments > 0) {
    while (k + 1 < segments && step_time(mesh, k + 1) <= time) ++k;
    const double begin = step_time(mesh, k);
    f = (time - begin) / (step_time(mesh, k + 1) - begin);
    f = f >= 0 && f <= 1 ? f : 0;  // also where it is NaN
  }
  for (std::size_t i = 0; i < 2 && k + i < mesh.steps.size(); ++i) {
    const VertexBufferView& step = mesh.steps[k + i];
    std::array<float, 3> q;
    std::memcpy(&q, static_cast<const char*>(step.data) + vertex * step.stride, sizeof q);
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += (i == 0 ? 1 - f : f) * q[axis];
  }
  return p;
}

/// Inside a triangle, on its edges or at its corners.
Vec3f take_target(ByteReader& in, const MeshView& mesh, float time) {
  const std::size_t prim = in.byte() % mesh.triangle_count;
  std::array<std::uint32_t, 3> corners;
  std::memcpy(&corners, static_cast<const char*>(mesh.indices) + prim * mesh.index_stride, sizeof corners);
  std::array<double, 3> weights;
  for (double& weight : weights) weight = in.below(16);
  const double sum = std::max(weights[0] + weights[1] + weights[2], 1.0);
  std::array<double, 3> target{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::array<double, 3> p = corner_at(mesh, corners[i], time);
    for (std::size_t axis = 0; axis < 3; ++axis) target[axis] += weights[i] / sum * p[axis];
  }
  return {static_cast<float>(target[0]), static_cast<float>(target[1]), static_cast<float>(target[2])};
}

}  // namespace

Ray take_ray(ByteReader& in, std::span<const MeshView> meshes) {
  const std::uint8_t kind = in.byte();
  if (kind >= 0xD0 || meshes.empty()) return in.take<Ray>();
  const MeshView& mesh = meshes[in.byte() % meshes.size()];
  const MeshView& clock = in.rarely() ? meshes[in.byte() % meshes.size()] : mesh;
  if (mesh.triangle_count == 0) return in.take<Ray>();
  Ray ray{};
  ray.time = take_time(in, clock);
  const Vec3f target = take_target(in, mesh, ray.time);
  const float x = in.number(), y = in.number(), z = in.number();
  const float distance = in.power_of_two(149), length = in.power_of_two(149);
  ray.origin = {target.x - distance * x, target.y - distance * y, target.z - distance * z};
  ray.direction = {length * x, length * y, length * z};
  ray.tnear = in.rarely() ? in.number() : 0.0f;
  ray.tfar = in.rarely() ? in.number() : kInf;
  ray.mask = in.rarely() ? in.take<std::uint32_t>() : 0xFFFFFFFFu;
  return ray;
}

}  // namespace stbvh::fuzz
