/// Moving triangles that are hard to bound: fast, thin or flat.
#pragma once

#include <cmath>

#include "test_meshes.h"

namespace stbvh::test {

/// `shape` gives the corners of a triangle around its centre; each triangle circles and sways by `sweep`.
template <typename Shape>
inline TestMesh swaying(std::size_t triangles, std::size_t steps, std::uint32_t seed, float sweep,
                        Shape shape) {
  Random random(seed);
  TestMesh mesh;
  mesh.positions.resize(steps);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const Vec3f centre = random.point(1.0f);
    const float phase = random.between(0, 6), speed = random.between(3, 60), radius = sweep * random.unit();
    Vec3f corners[3];
    shape(random, corners);
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      mesh.indices.push_back(3 * i + corner);
      for (std::size_t k = 0; k < steps; ++k) {
        const float angle = phase + speed * static_cast<float>(k) / static_cast<float>(steps);
        const Vec3f& d = corners[corner];
        mesh.positions[k].push_back({centre.x + radius * std::sin(angle) + d.x,
                                     centre.y + radius * std::cos(angle) + d.y,
                                     centre.z + 0.5f * radius * std::sin(1.7f * angle) + d.z});
      }
    }
  }
  return mesh;
}

inline TestMesh ordinary(std::size_t triangles, std::size_t steps, std::uint32_t seed, float sweep = 1.0f,
                         float size = 0.2f) {
  return swaying(triangles, steps, seed, sweep, [size](Random& random, Vec3f(&corners)[3]) {
    for (Vec3f& corner : corners) corner = random.point(size);
  });
}

inline TestMesh needles(std::size_t triangles, std::size_t steps, std::uint32_t seed) {
  return swaying(triangles, steps, seed, 0.3f, [](Random& random, Vec3f(&corners)[3]) {
    const Vec3f along = random.point(1.0f);
    const Vec3f across = random.point(std::pow(10.0f, -random.between(4, 6)));
    corners[0] = {-along.x, -along.y, -along.z};
    corners[1] = along;
    corners[2] = {along.x + across.x, along.y + across.y, along.z + across.z};
  });
}

/// Triangles exactly in planes axis = constant, moving within their plane or along its normal; every eighth
/// has collapsed to a line or to a point.
inline TestMesh flat(std::size_t triangles, std::size_t steps, std::uint32_t seed, bool in_one_plane) {
  Random random(seed);
  TestMesh mesh;
  mesh.positions.resize(steps);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const std::size_t axis = in_one_plane ? 2 : i % 3;
    const std::size_t moving = in_one_plane ? (axis + 1 + i % 2) % 3 : random.bits() % 3;
    float corners[3][3];
    for (auto& corner : corners) {
      for (float& x : corner) x = static_cast<float>(random.bits() % 17) / 8.0f - 1.0f;
      corner[axis] = in_one_plane ? 0.0f : corners[0][axis];
      if (i % 8 == 7) corner[(axis + 1) % 3] = corners[0][(axis + 1) % 3];
      if (i % 16 == 15) corner[(axis + 2) % 3] = corners[0][(axis + 2) % 3];
    }
    const float speed = static_cast<float>(random.bits() % 9) / 4.0f - 1.0f;
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      mesh.indices.push_back(3 * i + corner);
      for (std::size_t k = 0; k < steps; ++k) {
        float p[3] = {corners[corner][0], corners[corner][1], corners[corner][2]};
        p[moving] += speed * static_cast<float>(k) / static_cast<float>(steps);
        mesh.positions[k].push_back({p[0], p[1], p[2]});
      }
    }
  }
  return mesh;
}

}  // namespace stbvh::test
