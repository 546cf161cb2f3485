#include "mesh_bytes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "stbvh/structure.h"

namespace stbvh::fuzz {

namespace {

/// Bytes from one element to the next: mostly dense, sometimes unaligned, too short, or, where there is but
/// one element, enormous.
std::size_t take_stride(ByteReader& in, std::size_t elements) {
  constexpr std::size_t kDense = 12;
  if (!in.rarely()) return kDense;
  const std::size_t stride = in.below(40);
  return elements <= 1 && in.rarely() ? ~stride : stride;
}

std::vector<std::byte> make_buffer(std::size_t elements, std::size_t stride) {
  constexpr std::size_t kElement = 12;
  if (elements == 0) return {};
  return std::vector<std::byte>(kElement + (elements - 1) * std::max(stride, kElement));
}

void take_indices(ByteReader& in, std::size_t vertices, std::size_t triangles, FuzzMesh& mesh) {
  const std::size_t stride = take_stride(in, triangles);
  mesh.indices = make_buffer(triangles, stride);
  for (std::size_t triangle = 0; triangle < triangles; ++triangle) {
    std::array<std::uint32_t, 3> corners;
    for (std::uint32_t& corner : corners) {
      const std::uint8_t code = in.byte();
      corner = code < 0xFC && vertices > 0 ? code % static_cast<std::uint32_t>(vertices)
                                           : in.take<std::uint32_t>();
    }
    std::memcpy(mesh.indices.data() + triangle * std::max<std::size_t>(stride, sizeof corners), &corners,
                sizeof corners);
  }
  mesh.view.indices = mesh.indices.data();
  mesh.view.triangle_count = triangles;
  mesh.view.index_stride = stride;
}

/// In [-1, 1], another for each argument.
float noise(std::size_t step, std::size_t vertex, std::size_t axis) {
  const auto key = static_cast<std::uint32_t>((step * 256 + vertex) * 3 + axis);
  return static_cast<float>(key * 2654435761u >> 8) * 0x1p-23f - 1.0f;
}

/// Each vertex drifts and trembles; a few coordinates of a few steps are then replaced.
void fill_positions(ByteReader& in, std::size_t vertices, FuzzMesh& mesh) {
  const float scale = in.power_of_two(149);
  const float offset = in.rarely() ? in.number() : 0.0f;
  const float tremble = in.power_of_two(32) - 1.0f;
  const auto place = [&](std::size_t step, std::size_t vertex, std::size_t axis, float x) {
    const std::size_t at = vertex * std::max(mesh.steps[step].stride, sizeof(Vec3f)) + axis * sizeof x;
    std::memcpy(mesh.positions[step].data() + at, &x, sizeof x);
  };
  for (std::size_t vertex = 0; vertex < vertices; ++vertex) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float rest = in.number(), drift = in.number();
      for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
        if (vertex >= mesh.steps[step].count) continue;
        const float time = static_cast<float>(step) / static_cast<float>(mesh.steps.size());
        const float moved = rest + drift * time + tremble * noise(step, vertex, axis);
        place(step, vertex, axis, offset + scale * moved);
      }
    }
  }
  for (std::size_t left = in.below(8); left > 0 && !mesh.steps.empty(); --left) {
    const std::size_t step = in.byte() % mesh.steps.size();
    const std::size_t axis = in.below(3);
    if (const std::size_t vertex = in.below(32); vertex < mesh.steps[step].count) {
      place(step, vertex, axis, in.number());
    }
  }
}

void take_steps(ByteReader& in, std::size_t steps, std::size_t vertices, FuzzMesh& mesh) {
  const std::size_t stride = take_stride(in, vertices);
  mesh.steps.assign(steps, {nullptr, vertices, stride});
  if (steps > 0 && in.rarely()) mesh.steps[in.byte() % steps].stride = take_stride(in, vertices);
  if (steps > 0 && in.rarely()) mesh.steps[in.byte() % steps] = {nullptr, in.below(28)};
  for (VertexBufferView& step : mesh.steps) {
    mesh.positions.push_back(make_buffer(step.count, step.count > 1 ? step.stride : 0));
    step.data = mesh.positions.back().data();
  }
  fill_positions(in, vertices, mesh);
  if (steps > 0 && in.rarely()) mesh.steps[in.byte() % steps].data = nullptr;
  mesh.view.steps = mesh.steps;
}

TimeRange take_time_range(ByteReader& in) {
  const std::uint8_t code = in.byte();
  if (code < 0x60) return {};
  if (code < 0xC0) return {static_cast<float>(in.below(8)) / 8.0f, static_cast<float>(in.below(8)) / 7.0f};
  const float begin = in.number();
  return {begin, in.number()};
}

/// Mostly increasing, by an eighth or by next to nothing; sometimes anything, or one too few.
void take_step_times(ByteReader& in, FuzzMesh& mesh) {
  float time = in.rarely() ? in.number() : 0.0f;
  for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
    mesh.step_times.push_back(time);
    const std::uint8_t code = in.byte();
    time = code < 0x80   ? std::nextafter(time, 2.0f)
           : code < 0xF8 ? time + static_cast<float>(code & 7) / 64.0f + 1e-3f
                         : in.number();
  }
  if (in.rarely() && !mesh.step_times.empty()) mesh.step_times.pop_back();
  mesh.view.step_times = mesh.step_times;
}

}  // namespace

FuzzMesh take_mesh(ByteReader& in) {
  FuzzMesh mesh;
  const std::size_t steps = in.below(134), vertices = in.below(28), triangles = in.below(28);
  take_indices(in, vertices, triangles, mesh);
  mesh.view.time_range = take_time_range(in);
  take_steps(in, steps, vertices, mesh);
  if (in.below(4) == 0) take_step_times(in, mesh);
  if (in.rarely()) mesh.view.indices = nullptr;
  if (in.rarely()) mesh.view.triangle_count = std::size_t{kInvalidId} + 1 + in.byte();
  mesh.view.mask = in.rarely() ? in.take<std::uint32_t>() : 0xFFFFFFFFu;
  mesh.view.geom_id = in.byte();
  return mesh;
}

}  // namespace stbvh::fuzz
