/// A small cloth simulation (extended position based dynamics with small steps, Macklin et al. 2019) on a
/// grid of particles, and a smooth surface of any fineness over that grid.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "harness/scenes/procedural/shared/mesh_tools.h"

namespace stbvh::harness {

/// What acts on the cloth at `time` (seconds).
struct ClothWorld {
  double gravity = 9.81;
  double drag = 1.5;      ///< how much the wind takes the cloth along, 1/s
  double friction = 0.3;  ///< share of the sliding along colliders that is lost in each substep
  std::function<Vec3(Vec3 p, double time)> wind;
  /// Where a point inside an obstacle is pushed to; outside, the point itself.
  std::function<Vec3(Vec3 p, double time)> push_out;
  /// Where the pinned particle at column i of the first row is held; null: nothing is pinned.
  std::function<Vec3(std::size_t i, double time)> pin;
};

class Cloth {
 public:
  /// columns x rows particles at `start`, at rest when as far apart as in `rest`; with `closed` the last
  /// column is joined to the first.
  Cloth(std::size_t columns, std::size_t rows, bool closed,
        const std::function<Vec3(double u, double v)>& start,
        const std::function<Vec3(double u, double v)>& rest);

  /// Sets every particle in motion about the y axis.
  void spin(double radians_per_second);

  void run(const ClothWorld& world, double begin, double end, double substep);

  /// Columns and rows of quads of the fine surface are given to surface_indices; this is its vertex (u, v in
  /// [0, 1]).
  Vec3 surface(double u, double v) const;

 private:
  struct Link {
    std::size_t a, b;
    double length;
    double compliance;
  };

  std::size_t at(std::size_t i, std::size_t j) const { return j * columns_ + i; }
  void link(std::size_t i, std::size_t j, std::size_t di, std::size_t dj, double compliance,
            const std::vector<Vec3>& rest);
  void add_forces(const ClothWorld& world, double time, double dt);
  void solve(const ClothWorld& world, double time, double dt);
  Vec3 normal(std::size_t i, std::size_t j) const;
  /// Particle with indices continued beyond the border (around, or straight on).
  Vec3 control(std::ptrdiff_t i, std::ptrdiff_t j) const;

  std::size_t columns_, rows_;
  bool closed_;
  std::vector<Vec3> positions_, before_, velocities_;
  std::vector<Link> links_;
};

}  // namespace stbvh::harness
