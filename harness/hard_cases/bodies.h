/// Meshes that the hard cases are made of.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "harness/scenes/procedural/shared/mesh_tools.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// A closed, star-shaped, turning and bulging body. Whatever rounding does to its vertices, it winds around
/// every point nearer to its centre than kInnerRadius x radius: a ray from there hits it.
struct Body {
  std::size_t cuts = 16;  ///< of each edge of an octahedron: 8 cuts^2 triangles
  std::size_t segments = 1;
  double radius = 1;
  Vec3 center{};
  Vec3 drift{};        ///< of the centre, over the shutter
  double turn = 1;     ///< radians over the shutter
  double bulge = 0.2;  ///< share of the radius
  Vec3 stretch{1, 1, 1};
  std::vector<float>
      step_times{};  ///< of its segments' ends; it moves by as much in each. Empty: equidistant

  Vec3 center_at(double shutter_fraction) const { return center + drift * shutter_fraction; }
};

/// Safe for a turn of at most one radian in a segment.
inline constexpr double kInnerRadius = 0.2;

/// Cuts that make about 2,000 and 160,000 triangles.
inline constexpr std::size_t kCuts2k = 16;
inline constexpr std::size_t kCuts160k = 142;

Mesh make_body(const Body& body);

/// The triangulated unit sphere that bodies are made of: an octahedron with each edge cut in `cuts`.
Shape cut_octahedron(std::size_t cuts);

using Corners = std::array<Vec3, 3>;
/// Corners of one triangle over the shutter, 0 to 1.
using MovingCorners = std::function<Corners(double)>;

/// Triangles without shared vertices: `make` is called once for each and says how it moves.
Mesh make_soup(std::size_t triangles, std::size_t segments, Pcg32& random,
               const std::function<MovingCorners(Pcg32&)>& make);

/// Corners that drift by up to `reach` over the shutter, each triangle as a whole.
MovingCorners drifting(const Corners& corners, double reach, Pcg32& random);

/// Corners that each go their own way, by up to `reach`.
MovingCorners bending(const Corners& corners, double reach, Pcg32& random);

/// Uniform in the cube [-extent, extent]^3.
Vec3 random_point(Pcg32& random, double extent);

/// A triangle about `center` with corners in a cube of half-width `size`.
Corners random_corners(Pcg32& random, Vec3 center, double size);

/// A waving sheet of 2 cuts^2 triangles over [-size, size]^2, moved by `center`.
Mesh make_sheet(std::size_t cuts, std::size_t segments, double size, Vec3 center);

Scene one_mesh(Mesh mesh);

}  // namespace stbvh::harness
