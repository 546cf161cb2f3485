/// Motions and surfaces from which the procedural scenes are made.
///
/// Scenes are worked out in double precision and stored as float, so that a scene is the same whatever the
/// compiler contracts or the number of threads is.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/pcg32.h"
#include "harness/scenes/quaternion.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// The turn that takes the pair (a, b) of directions to (c, d), b and d made perpendicular to a and c.
Quaternion align(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

/// Rotation, then translation.
struct Rigid {
  Quaternion rotation;
  Vec3 translation;

  Vec3 apply(Vec3 p) const { return rotate(rotation, p) + translation; }
};

/// `a` after `b`.
Rigid operator*(const Rigid& a, const Rigid& b);
Rigid inverse(const Rigid& a);
inline Rigid translation(Vec3 t) {
  return {Quaternion{}, t};
}
inline Rigid rotation(Vec3 axis, double radians) {
  return {axis_angle(axis, radians), Vec3{}};
}
/// Rotation about an axis through `pivot`.
Rigid rotation_about(Vec3 pivot, Vec3 axis, double radians);

/// A rest shape: positions, and triangles that share them.
struct Shape {
  std::vector<Vec3> positions;
  std::vector<std::uint32_t> indices;

  std::size_t triangle_count() const { return indices.size() / 3; }
  /// Appends `other`; returns the index of its first vertex.
  std::size_t append(const Shape& other);
  void transform(const Rigid& motion);
  /// Multiplies all positions by the factors of `s`.
  void stretch(Vec3 s);
};

/// Whether the last row or column of a grid is the first one again.
enum class Wrap { kNone, kU, kBoth };

/// Surface f(u, v) over [0,1]^2 in nu x nv quads, two triangles each: 2 nu nv triangles.
Shape make_grid(std::size_t nu, std::size_t nv, const std::function<Vec3(double, double)>& f,
                Wrap wrap = Wrap::kNone);

/// One cross-section of a tube: centre and half-width (across) and half-depth (along the frame's second
/// axis).
struct TubeSection {
  Vec3 center;
  double half_width;
  double half_depth;
};

/// Tube through `sections`, `around` vertices each, closed by a fan at both ends if `capped`.
/// `side` is a vector that the half-widths lie along (made perpendicular to the curve at each section).
/// 2 around (sections - 1) triangles, and 2 (around - 2) for the caps.
Shape make_tube(const std::vector<TubeSection>& sections, std::size_t around, Vec3 side, bool capped = true);

/// Tapered capsule from `a` to `b` with round ends; `along` rings on the shaft, `around` vertices each.
/// The ends are poles: 2 around (along + 2 (around/4) - 1) triangles or so.
Shape make_capsule(Vec3 a, Vec3 b, double radius_a, double radius_b, std::size_t around, std::size_t along);

/// Box of half-extents `half` about `center`, each face in n x n quads, vertices shared along edges of a face
/// only: 12 n n triangles.
Shape make_box(Vec3 center, Vec3 half, std::size_t n = 1);

/// Surface of revolution about the y axis through profile points (radius, height), `around` segments;
/// 2 around (points - 1) triangles, open at both ends unless a radius is 0. A closed torus-like profile
/// repeats its first point.
struct ProfilePoint {
  double radius;
  double height;
};
Shape make_revolution(const std::vector<ProfilePoint>& profile, std::size_t around);

/// Ellipsoid about the origin, 2 around (rings - 1) triangles.
Shape make_ellipsoid(Vec3 half, std::size_t around, std::size_t rings);

/// Time of step k of `steps` in [0, 1].
inline double step_time(std::size_t k, std::size_t steps) {
  return steps > 1 ? static_cast<double>(k) / static_cast<double>(steps - 1) : 0.0;
}

/// Steps of `vertex_count` vertices: position(vertex, step) -> Vec3, called from many threads at once; the
/// result does not depend on how many.
template <class Position>
std::vector<VertexBuffer> make_steps(std::size_t vertex_count, std::size_t steps, const Position& position) {
  std::vector<VertexBuffer> buffers;
  buffers.reserve(steps);
  for (std::size_t k = 0; k < steps; ++k) {
    VertexBuffer& buffer = buffers.emplace_back(vertex_count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertex_count, 1024),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t i = range.begin(); i < range.end(); ++i)
                          buffer[i] = to_float(position(i, k));
                      });
    check_cancelled();
  }
  return buffers;
}

/// The same for position(vertex, time) -> Vec3.
template <class Position>
std::vector<VertexBuffer> evaluate_steps(std::size_t vertex_count, std::size_t steps,
                                         const Position& position) {
  return make_steps(vertex_count, steps,
                    [&](std::size_t i, std::size_t k) { return position(i, step_time(k, steps)); });
}

/// A mesh of `shape`'s triangles whose vertices move as motion(rest position, vertex, time) -> Vec3 says.
template <class Motion>
Mesh animate(std::string name, const Shape& shape, std::size_t steps, Vec3f color, const Motion& motion) {
  Mesh mesh;
  mesh.name = std::move(name);
  mesh.indices = shape.indices;
  mesh.material.color = color;
  mesh.steps = evaluate_steps(shape.positions.size(), steps, [&](std::size_t i, double time) {
    return motion(shape.positions[i], i, time);
  });
  return mesh;
}

/// Appends `mesh` unless it has no triangles.
void add_mesh(Scene& scene, Mesh&& mesh);

/// `full` times the square root of triangles / full_triangles, between `least` and `full`: how finely to cut
/// a part so that it keeps its share.
std::size_t detail(std::size_t full, std::size_t least, std::size_t triangles, double full_triangles);

/// A mesh that stands still (one step).
Mesh make_static_mesh(std::string name, const Shape& shape, Vec3f color);

}  // namespace stbvh::harness
