#include "harness/cli/turning_bar.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stbvh::harness {
namespace {

constexpr double kRadius = 0.16;
constexpr double kBumps = 0.25;  // of the radius

/// Rings of vertices from one end to the other, and a vertex at each end.
struct Rings {
  std::size_t around, along;

  explicit Rings(std::size_t triangles)
      : around(std::max<std::size_t>(
            6, static_cast<std::size_t>(std::sqrt(static_cast<double>(triangles) / 8)))),
        along(std::max<std::size_t>(5, triangles / (2 * around)) - 1) {}
  std::size_t vertices() const { return (along + 1) * around + 2; }
  std::uint32_t at(std::size_t ring, std::size_t i) const {
    return static_cast<std::uint32_t>(ring * around + i % around);
  }
  std::uint32_t end(std::size_t which) const { return static_cast<std::uint32_t>(vertices() - 2 + which); }
};

std::vector<std::uint32_t> triangles_of(const Rings& rings) {
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < rings.around; ++i) {
    for (std::size_t ring = 0; ring < rings.along; ++ring) {
      const std::uint32_t a = rings.at(ring, i), b = rings.at(ring, i + 1);
      const std::uint32_t c = rings.at(ring + 1, i), d = rings.at(ring + 1, i + 1);
      indices.insert(indices.end(), {a, b, c, c, b, d});
    }
    indices.insert(indices.end(), {rings.end(0), rings.at(0, i + 1), rings.at(0, i)});
    indices.insert(indices.end(), {rings.end(1), rings.at(rings.along, i), rings.at(rings.along, i + 1)});
  }
  return indices;
}

VertexBuffer vertices_at(const Rings& rings, double angle) {
  const double cosine = std::cos(angle), sine = std::sin(angle);
  VertexBuffer vertices(rings.vertices());
  const auto put = [&](std::uint32_t index, double x, double y, double z) {
    vertices[index] = {static_cast<float>(cosine * x - sine * y), static_cast<float>(sine * x + cosine * y),
                       static_cast<float>(z)};
  };
  constexpr double kTurn = 2 * std::numbers::pi;
  for (std::size_t ring = 0; ring <= rings.along; ++ring) {
    const double along = static_cast<double>(ring) / static_cast<double>(rings.along);
    for (std::size_t i = 0; i < rings.around; ++i) {
      const double around = kTurn * static_cast<double>(i) / static_cast<double>(rings.around);
      const double bump = std::cos(2 * around) * std::sin(5 * kTurn * along);
      const double radius = kRadius * (1 + kBumps * bump);
      put(rings.at(ring, i), 2 * along - 1, radius * std::cos(around), radius * std::sin(around));
    }
  }
  put(rings.end(0), -1, 0, 0);
  put(rings.end(1), 1, 0, 0);
  return vertices;
}

}  // namespace

Scene make_turning_bar(double turns, std::size_t steps, std::size_t triangles) {
  const Rings rings(triangles);
  Mesh bar;
  bar.name = "bar";
  bar.indices = triangles_of(rings);
  for (std::size_t step = 0; step < steps; ++step) {
    const double time = static_cast<double>(step) / static_cast<double>(steps - 1);
    bar.steps.push_back(vertices_at(rings, 2 * std::numbers::pi * turns * time));
  }
  Scene scene;
  scene.name = "turning-bar";
  scene.meshes.push_back(std::move(bar));
  scene.camera.position = {0, 0, 3};
  return scene;
}

}  // namespace stbvh::harness
