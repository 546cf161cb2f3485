/// Small scenes for the harness's tests.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

#include "harness/scenes/pcg32.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// One triangle with the given corners in each step.
inline Mesh one_triangle(std::initializer_list<std::array<Vec3f, 3>> steps) {
  Mesh mesh;
  mesh.indices = {0, 1, 2};
  for (const std::array<Vec3f, 3>& corners : steps) {
    VertexBuffer& buffer = mesh.steps.emplace_back(3);
    for (std::size_t c = 0; c < 3; ++c) buffer[c] = corners[c];
  }
  return mesh;
}

/// Triangles scattered in [0, 10]^3, each wandering from step to step.
inline Mesh wandering_triangles(std::size_t count, std::size_t steps, Pcg32& random) {
  Mesh mesh;
  const auto vector = [&](double size) {
    const double x = random.uniform(-size, size);
    const double y = random.uniform(-size, size);
    return Vec3{x, y, random.uniform(-size, size)};
  };
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 center = Vec3{5, 5, 5} + vector(5);
    for (int c = 0; c < 3; ++c) points.push_back(center + vector(0.6));
  }
  for (std::size_t i = 0; i < points.size(); ++i) mesh.indices.push_back(static_cast<std::uint32_t>(i));
  for (std::size_t k = 0; k < steps; ++k) {
    VertexBuffer& buffer = mesh.steps.emplace_back(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i % 3 == 0) {
        const Vec3 shift = vector(0.5);
        for (std::size_t c = 0; c < 3; ++c) points[i + c] = points[i + c] + shift;
      }
      buffer[i] = to_float(points[i]);
    }
  }
  return mesh;
}

/// Meshes with 1 to 7 steps that do not divide each other, two of them with time ranges of their own.
inline Scene mixed_step_scene(std::size_t triangles_per_mesh = 300) {
  Scene scene;
  scene.name = "mixed";
  scene.camera.position = {5, 5, 30};
  scene.camera.target = {5, 5, 5};
  Pcg32 random(7);
  for (std::size_t steps : std::initializer_list<std::size_t>{1, 2, 3, 4, 6, 7, 3, 5}) {
    scene.meshes.push_back(wandering_triangles(triangles_per_mesh, steps, random));
  }
  scene.meshes[6].time_range = {0.25f, 0.75f};
  scene.meshes[7].time_range = {0.1f, 0.9f};
  return scene;
}

/// Meshes whose steps have times of their own: few, more than Embree takes, an ulp apart, and there for a
/// part of the shutter; and two without.
inline Scene uneven_step_scene(std::size_t triangles_per_mesh = 300) {
  Scene scene;
  scene.name = "uneven";
  scene.camera.position = {5, 5, 30};
  scene.camera.target = {5, 5, 5};
  Pcg32 random(8);
  std::vector<float> many;
  for (int i = 0; i <= 200; ++i) {
    const float f = static_cast<float>(i) / 200.0f;
    many.push_back(f * f);
  }
  for (const std::vector<float>& times : std::initializer_list<std::vector<float>>{
           {}, {0, 0.1f, 1}, many, {0, 0.5f, 0.5f + 0x1p-24f, 0.9f, 1}, {0.25f, 0.3f, 0.7f}}) {
    scene.meshes.push_back(wandering_triangles(triangles_per_mesh, times.empty() ? 4 : times.size(), random));
    scene.meshes.back().step_times = times;
  }
  scene.meshes.push_back(wandering_triangles(triangles_per_mesh, 1, random));
  return scene;
}

inline Ray ray_along_z(float x, float y, float time = 0.0f) {
  return {.origin = {x, y, -1},
          .tnear = 0,
          .direction = {0, 0, 1},
          .time = time,
          .tfar = 100,
          .mask = 0xFFFFFFFFu};
}

}  // namespace stbvh::harness
