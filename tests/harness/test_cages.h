/// Cages of subdivision surfaces about which something is known.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "harness/scenes/subdivision/subdivision.h"

namespace stbvh::harness {

inline VertexBuffer buffer_of(const std::vector<Vec3f>& points) {
  VertexBuffer buffer(points.size());
  std::copy(points.begin(), points.end(), buffer.data());
  return buffer;
}

/// From -1 to 1, faces outward; vertex bits are x, y, z.
inline SubdivisionCage cube() {
  SubdivisionCage cage;
  cage.face_sizes.assign(6, 4);
  cage.face_vertices = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
  std::vector<Vec3f> points;
  for (int v = 0; v < 8; ++v) points.push_back({v & 1 ? 1.f : -1.f, v & 2 ? 1.f : -1.f, v & 4 ? 1.f : -1.f});
  cage.steps = {buffer_of(points)};
  return cage;
}

inline SubdivisionCage cube_with_creases(float sharpness) {
  SubdivisionCage cage = cube();
  for (std::uint32_t v = 0; v < 8; ++v) {
    for (std::uint32_t bit = 1; bit < 8; bit *= 2) {
      if ((v & bit) == 0) cage.edge_creases.push_back({v, v | bit, sharpness});
    }
  }
  return cage;
}

inline SubdivisionCage square(SubdivisionCage::Boundary boundary) {
  SubdivisionCage cage;
  cage.face_sizes = {4};
  cage.face_vertices = {0, 1, 2, 3};
  cage.steps = {buffer_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}})};
  cage.boundary = boundary;
  return cage;
}

inline double height(std::size_t i, std::size_t j) {
  return std::sin(12.9 * static_cast<double>(i) + 78.2 * static_cast<double>(j));
}

/// count x count vertices at (i, j, height).
inline SubdivisionCage grid(std::uint32_t count, SubdivisionCage::Boundary boundary) {
  SubdivisionCage cage;
  std::vector<Vec3f> points;
  for (std::uint32_t j = 0; j < count; ++j) {
    for (std::uint32_t i = 0; i < count; ++i) {
      points.push_back({static_cast<float>(i), static_cast<float>(j), static_cast<float>(height(i, j))});
      if (i + 1 == count || j + 1 == count) continue;
      const std::uint32_t v = j * count + i;
      cage.face_sizes.push_back(4);
      for (const std::uint32_t corner : {v, v + 1, v + count + 1, v + count})
        cage.face_vertices.push_back(corner);
    }
  }
  cage.steps = {buffer_of(points)};
  cage.boundary = boundary;
  return cage;
}

inline SubdivisionCage moving_cube(std::size_t steps) {
  SubdivisionCage cage = cube_with_creases(0.7f);
  const VertexBuffer rest = cage.steps[0];
  for (std::size_t s = 1; s < steps; ++s) {
    const float angle = 0.4f * static_cast<float>(s);
    VertexBuffer& step = cage.steps.emplace_back(rest.size());
    for (std::size_t v = 0; v < rest.size(); ++v) {
      step[v] = {std::cos(angle) * rest[v].x - std::sin(angle) * rest[v].y,
                 std::sin(angle) * rest[v].x + std::cos(angle) * rest[v].y, rest[v].z + angle};
    }
  }
  return cage;
}

/// A pyramid on a pentagon: triangles, a face of five corners, and vertices of three and five edges.
inline SubdivisionCage pyramid() {
  SubdivisionCage cage;
  std::vector<Vec3f> points{{0, 0, 2}};
  cage.face_sizes = {5};
  cage.face_vertices = {5, 4, 3, 2, 1};
  for (std::uint32_t i = 0; i < 5; ++i) {
    const float angle = 1.25664f * static_cast<float>(i);
    points.push_back({std::cos(angle), std::sin(angle), 0});
    cage.face_sizes.push_back(3);
    for (const std::uint32_t corner : {0u, i + 1, (i + 1) % 5 + 1}) cage.face_vertices.push_back(corner);
  }
  cage.steps = {buffer_of(points)};
  return cage;
}

/// `count` triangles around a vertex at (0, 0, 1).
inline SubdivisionCage wheel(std::uint32_t count) {
  SubdivisionCage cage;
  std::vector<Vec3f> points{{0, 0, 1}};
  cage.face_sizes.assign(count, 3);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 6.283185307179586 * i / count;
    points.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0});
    for (const std::uint32_t corner : {0u, i + 1, (i + 1) % count + 1}) cage.face_vertices.push_back(corner);
  }
  cage.steps = {buffer_of(points)};
  return cage;
}

/// One face of `count` corners, on the unit circle.
inline SubdivisionCage disc(std::uint32_t count) {
  const SubdivisionCage around = wheel(count);
  SubdivisionCage cage;
  cage.face_sizes = {count};
  for (std::uint32_t i = 0; i < count; ++i) cage.face_vertices.push_back(i);
  const auto points = around.steps[0].span();
  cage.steps = {buffer_of({points.begin() + 1, points.end()})};
  return cage;
}

}  // namespace stbvh::harness
