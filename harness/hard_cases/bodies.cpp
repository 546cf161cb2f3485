#include "harness/hard_cases/bodies.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace stbvh::harness {
namespace {

constexpr Vec3f kColor{0.7f, 0.7f, 0.7f};

/// Shares the vertices of a cut octahedron between its faces by their place on the lattice.
class LatticeVertices {
 public:
  explicit LatticeVertices(Shape& shape) : shape_(shape) {}

  std::uint32_t at(std::array<int, 3> place) {
    const auto [entry, is_new] = known_.try_emplace(place, static_cast<std::uint32_t>(known_.size()));
    if (is_new) {
      const auto [x, y, z] = place;
      shape_.positions.push_back(
          normalize({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}));
    }
    return entry->second;
  }

 private:
  Shape& shape_;
  std::map<std::array<int, 3>, std::uint32_t> known_;
};

void add_face(Shape& shape, LatticeVertices& vertices, int n, std::array<int, 3> sign) {
  const auto at = [&](int i, int j) {
    return vertices.at({sign[0] * i, sign[1] * j, sign[2] * (n - i - j)});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      shape.indices.insert(shape.indices.end(), {at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + j + 2 > n) continue;
      shape.indices.insert(shape.indices.end(), {at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
}

}  // namespace

Shape cut_octahedron(std::size_t cuts) {
  Shape shape;
  LatticeVertices vertices(shape);
  for (const int x : {-1, 1}) {
    for (const int y : {-1, 1}) {
      for (const int z : {-1, 1}) add_face(shape, vertices, static_cast<int>(cuts), {x, y, z});
    }
  }
  return shape;
}

Mesh make_body(const Body& body) {
  const Vec3 axis = normalize({1, 2, 3});
  Mesh mesh = animate(
      "body", cut_octahedron(body.cuts), body.segments + 1, kColor, [&](Vec3 u, std::size_t, double time) {
        const double wave = std::sin(4 * u.x + 7 * time) * std::cos(3 * u.y - 5 * time + u.z);
        const double radius = body.radius * (1 + body.bulge * wave);
        const Vec3 p = rotate(axis_angle(axis, body.turn * time), radius * u);
        return body.center_at(time) + Vec3{p.x * body.stretch.x, p.y * body.stretch.y, p.z * body.stretch.z};
      });
  mesh.step_times = body.step_times;
  return mesh;
}

Mesh make_soup(std::size_t triangles, std::size_t segments, Pcg32& random,
               const std::function<MovingCorners(Pcg32&)>& make) {
  Mesh mesh;
  mesh.name = "soup";
  mesh.steps.assign(segments + 1, VertexBuffer(3 * triangles));
  for (std::size_t i = 0; i < triangles; ++i) {
    const MovingCorners corners_at = make(random);
    for (std::size_t k = 0; k <= segments; ++k) {
      const Corners corners = corners_at(step_time(k, segments + 1));
      for (std::size_t c = 0; c < 3; ++c) mesh.steps[k][3 * i + c] = to_float(corners[c]);
    }
    for (std::size_t c = 0; c < 3; ++c) mesh.indices.push_back(static_cast<std::uint32_t>(3 * i + c));
  }
  return mesh;
}

MovingCorners drifting(const Corners& corners, double reach, Pcg32& random) {
  const Vec3 way = random_point(random, reach);
  const double phase = random.uniform(0, 2 * kPi);
  return [=](double time) {
    const Vec3 shift = way * std::sin(phase + 4 * time);
    return Corners{corners[0] + shift, corners[1] + shift, corners[2] + shift};
  };
}

MovingCorners bending(const Corners& corners, double reach, Pcg32& random) {
  const Corners ways = random_corners(random, {}, reach);
  const double phase = random.uniform(0, 2 * kPi);
  return [=](double time) {
    const double wave = std::sin(phase + 4 * time);
    return Corners{corners[0] + ways[0] * wave, corners[1] + ways[1] * wave, corners[2] + ways[2] * wave};
  };
}

Vec3 random_point(Pcg32& random, double extent) {
  const double x = random.uniform(-extent, extent);
  const double y = random.uniform(-extent, extent);
  const double z = random.uniform(-extent, extent);
  return {x, y, z};
}

Corners random_corners(Pcg32& random, Vec3 center, double size) {
  const Vec3 a = random_point(random, size);
  const Vec3 b = random_point(random, size);
  const Vec3 c = random_point(random, size);
  return {center + a, center + b, center + c};
}

Mesh make_sheet(std::size_t cuts, std::size_t segments, double size, Vec3 center) {
  const Shape flat = make_grid(cuts, cuts, [](double u, double v) { return Vec3{2 * u - 1, 0, 2 * v - 1}; });
  return animate("sheet", flat, segments + 1, kColor, [&](Vec3 p, std::size_t, double time) {
    const double height = 0.2 * std::sin(5 * p.x + 6 * time) * std::cos(4 * p.z - 3 * time);
    return center + size * Vec3{p.x + 0.1 * time, height, p.z};
  });
}

Scene one_mesh(Mesh mesh) {
  Scene scene;
  scene.name = mesh.name;
  scene.meshes.push_back(std::move(mesh));
  return scene;
}

}  // namespace stbvh::harness
