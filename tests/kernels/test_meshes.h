/// Small animated meshes for the tests of the kernels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "stbvh/structure.h"
#include "tests/random.h"

namespace stbvh::test {

/// Rays or runs of a test: all, or a twentieth under the thread sanitizer, which is slow and finds no more in
/// more rays.
constexpr int count(int all) {
#ifdef __SANITIZE_THREAD__
  return all / 20 > 0 ? all / 20 : 1;
#else
  return all;
#endif
}

/// Owns the buffers that a MeshView points to.
struct TestMesh {
  std::vector<std::uint32_t> indices;
  std::vector<std::vector<Vec3f>> positions;  ///< [step][vertex]
  std::vector<VertexBufferView> steps;
  TimeRange time_range;
  std::vector<float> step_times = {};  ///< empty: equidistant
  std::uint32_t mask = 0xFFFFFFFFu;
  std::uint32_t geom_id = 0;

  float time_of_step(std::size_t step) const {
    if (!step_times.empty()) return step_times[step];
    const double share = static_cast<double>(step) / static_cast<double>(positions.size() - 1);
    return static_cast<float>(time_range.begin +
                              share * (static_cast<double>(time_range.end) - time_range.begin));
  }

  MeshView view() {
    steps.clear();
    for (const auto& step : positions) steps.push_back({step.data(), step.size(), sizeof(Vec3f)});
    MeshView v;
    v.indices = indices.data();
    v.triangle_count = indices.size() / 3;
    v.steps = steps;
    v.time_range = time_range;
    v.step_times = step_times;
    v.mask = mask;
    v.geom_id = geom_id;
    return v;
  }
};

/// The mesh scaled, mirrored in y, and moved by `offset` along each axis.
inline TestMesh placed(TestMesh mesh, float scale, float offset) {
  for (auto& step : mesh.positions) {
    for (Vec3f& p : step) p = {offset + scale * p.x, offset - scale * p.y, offset + scale * p.z};
  }
  return mesh;
}

/// The mesh alive in `range`.
inline TestMesh timed(TestMesh mesh, TimeRange range) {
  mesh.time_range = range;
  return mesh;
}

/// The mesh with its steps at `times`.
inline TestMesh at_times(TestMesh mesh, std::vector<float> times) {
  mesh.time_range = {times.front(), times.back()};
  mesh.step_times = std::move(times);
  return mesh;
}

/// Strictly increasing, from `begin` to `end`, mostly near to each other.
inline std::vector<float> uneven_times(std::size_t steps, std::uint32_t seed, float begin = 0.0f,
                                       float end = 1.0f) {
  Random random(seed);
  std::vector<float> times{begin, end};
  while (times.size() < steps) {
    const float x = random.unit();
    times.push_back(begin + (end - begin) * x * x * x);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
  }
  return times;
}

using Motion = std::function<Vec3f(Vec3f, float)>;

/// Rotation about z, bulging, and a drift along x: curved motion of moderate speed.
inline Vec3f tumble(Vec3f p, float t) {
  const float angle = 2.0f * t;
  const float bulge = 1.0f + 0.2f * std::sin(5.0f * t + 3.0f * p.z);
  const float x = p.x * bulge, y = p.y * bulge;
  return {x * std::cos(angle) - y * std::sin(angle) + 0.7f * t, x * std::sin(angle) + y * std::cos(angle),
          p.z};
}

inline void animate(TestMesh& mesh, const std::vector<Vec3f>& rest, std::size_t steps, const Motion& motion) {
  for (std::size_t k = 0; k < steps; ++k) {
    const float t = steps > 1 ? static_cast<float>(k) / static_cast<float>(steps - 1) : 0.0f;
    std::vector<Vec3f> moved;
    for (const Vec3f& p : rest) moved.push_back(motion(p, t));
    mesh.positions.push_back(std::move(moved));
  }
}

/// A closed sphere of radius 1 around `centre` (2 * rings * rings - 2 * ... triangles), all vertices shared.
inline TestMesh sphere(std::uint32_t rings, std::size_t steps, const Motion& motion = tumble,
                       Vec3f centre = {0, 0, 0}) {
  std::vector<Vec3f> rest;
  const std::uint32_t around = 2 * rings;
  rest.push_back({centre.x, centre.y, centre.z + 1});
  for (std::uint32_t r = 1; r < rings; ++r) {
    const float theta = std::numbers::pi_v<float> * static_cast<float>(r) / static_cast<float>(rings);
    for (std::uint32_t a = 0; a < around; ++a) {
      const float phi = 2 * std::numbers::pi_v<float> * static_cast<float>(a) / static_cast<float>(around);
      rest.push_back({centre.x + std::sin(theta) * std::cos(phi), centre.y + std::sin(theta) * std::sin(phi),
                      centre.z + std::cos(theta)});
    }
  }
  rest.push_back({centre.x, centre.y, centre.z - 1});
  TestMesh mesh;
  const auto vertex = [&](std::uint32_t r, std::uint32_t a) { return 1 + (r - 1) * around + a % around; };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.indices.insert(mesh.indices.end(), {a, b, c});
  };
  const auto bottom = static_cast<std::uint32_t>(rest.size() - 1);
  for (std::uint32_t a = 0; a < around; ++a) {
    add(0, vertex(1, a), vertex(1, a + 1));
    for (std::uint32_t r = 1; r + 1 < rings; ++r) {
      add(vertex(r, a), vertex(r + 1, a), vertex(r + 1, a + 1));
      add(vertex(r, a), vertex(r + 1, a + 1), vertex(r, a + 1));
    }
    add(vertex(rings - 1, a), bottom, vertex(rings - 1, a + 1));
  }
  animate(mesh, rest, steps, motion);
  return mesh;
}

/// Triangles without shared vertices at random places, each with a motion of its own.
inline TestMesh soup(std::size_t triangles, std::size_t steps, std::uint32_t seed, float size = 0.3f) {
  Random random(seed);
  TestMesh mesh;
  mesh.positions.resize(steps);
  for (std::size_t i = 0; i < triangles; ++i) {
    const Vec3f centre = random.point(1.5f);
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      mesh.indices.push_back(static_cast<std::uint32_t>(3 * i + corner));
      Vec3f p = random.point(size);
      for (auto& step : mesh.positions) {
        step.push_back({centre.x + p.x, centre.y + p.y, centre.z + p.z});
        const Vec3f d = random.point(0.2f);
        p = {p.x + d.x, p.y + d.y, p.z + d.z};
      }
    }
  }
  return mesh;
}

inline Ray random_ray(Random& random, float extent = 2.5f) {
  const Vec3f origin = random.point(extent);
  const Vec3f target = random.point(1.5f);
  Ray ray{};
  ray.origin = origin;
  ray.direction = {target.x - origin.x, target.y - origin.y, target.z - origin.z};
  ray.tnear = 0.0f;
  ray.tfar = std::numeric_limits<float>::infinity();
  ray.time = random.unit();
  ray.mask = 0xFFFFFFFFu;
  return ray;
}

}  // namespace stbvh::test
