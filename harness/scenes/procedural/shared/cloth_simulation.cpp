#include "harness/scenes/procedural/shared/cloth_simulation.h"

#include <algorithm>
#include <array>

#include "harness/scenes/cancellation.h"

namespace stbvh::harness {
namespace {

/// Inverse stiffness of threads, of the diagonals and of bending (metres per newton, particles of unit mass).
constexpr double kThreadCompliance = 1e-7;
constexpr double kShearCompliance = 2e-4;
constexpr double kBendCompliance = 4e-3;
/// Share of its velocity that the cloth keeps in a second.
constexpr double kInnerDamping = 0.8;

/// Weights of the uniform cubic B-spline at fraction f between its two middle points.
std::array<double, 4> spline_weights(double f) {
  const double g = 1 - f;
  return {g * g * g / 6, (3 * f * f * f - 6 * f * f + 4) / 6, (3 * g * g * g - 6 * g * g + 4) / 6,
          f * f * f / 6};
}

}  // namespace

Cloth::Cloth(std::size_t columns, std::size_t rows, bool closed,
             const std::function<Vec3(double u, double v)>& start,
             const std::function<Vec3(double u, double v)>& rest)
    : columns_(columns), rows_(rows), closed_(closed) {
  std::vector<Vec3> rest_positions;
  const auto last_column = static_cast<double>(closed ? columns : columns - 1);
  for (std::size_t j = 0; j < rows; ++j) {
    for (std::size_t i = 0; i < columns; ++i) {
      const double u = static_cast<double>(i) / last_column;
      const double v = static_cast<double>(j) / static_cast<double>(rows - 1);
      positions_.push_back(start(u, v));
      rest_positions.push_back(rest(u, v));
    }
  }
  before_ = positions_;
  velocities_.resize(positions_.size());
  for (std::size_t j = 0; j < rows; ++j) {
    for (std::size_t i = 0; i < columns; ++i) {
      link(i, j, 1, 0, kThreadCompliance, rest_positions);
      link(i, j, 0, 1, kThreadCompliance, rest_positions);
      link(i, j, 1, 1, kShearCompliance, rest_positions);
      if (i > 0 || closed) link(i, j, columns - 1, 1, kShearCompliance, rest_positions);
      link(i, j, 2, 0, kBendCompliance, rest_positions);
      link(i, j, 0, 2, kBendCompliance, rest_positions);
    }
  }
}

void Cloth::link(std::size_t i, std::size_t j, std::size_t di, std::size_t dj, double compliance,
                 const std::vector<Vec3>& rest) {
  // A step back by one column is written as columns - 1 forward.
  const bool back = di + 1 == columns_;
  if (j + dj >= rows_ || (!closed_ && !back && i + di >= columns_)) return;
  const std::size_t a = at(i, j);
  const std::size_t b = at((i + di) % columns_, j + dj);
  links_.push_back({a, b, length(rest[b] - rest[a]), compliance});
}

void Cloth::spin(double radians_per_second) {
  for (std::size_t k = 0; k < positions_.size(); ++k)
    velocities_[k] = cross(Vec3{0, radians_per_second, 0}, positions_[k]);
}

Vec3 Cloth::normal(std::size_t i, std::size_t j) const {
  const auto x = static_cast<std::ptrdiff_t>(i), y = static_cast<std::ptrdiff_t>(j);
  return normalize(cross(control(x + 1, y) - control(x - 1, y), control(x, y + 1) - control(x, y - 1)));
}

void Cloth::add_forces(const ClothWorld& world, double time, double dt) {
  for (std::size_t j = 0; j < rows_; ++j) {
    for (std::size_t i = 0; i < columns_; ++i) {
      Vec3& v = velocities_[at(i, j)];
      const Vec3 n = normal(i, j);
      const Vec3 relative = world.wind(positions_[at(i, j)], time) - v;
      // Mostly what blows against the face counts.
      v = v + (n * (0.9 * dot(n, relative)) + relative * 0.1) * (world.drag * dt);
      v = v * (1 - (1 - kInnerDamping) * dt) - Vec3{0, world.gravity * dt, 0};
    }
  }
}

void Cloth::solve(const ClothWorld& world, double time, double dt) {
  for (const Link& link : links_) {
    Vec3& a = positions_[link.a];
    Vec3& b = positions_[link.b];
    const Vec3 d = b - a;
    const double l = std::max(length(d), 1e-12);
    const Vec3 move = d * ((l - link.length) / (l * (2 + link.compliance / (dt * dt))));
    a = a + move;
    b = b - move;
  }
  for (std::size_t k = 0; k < positions_.size(); ++k) {
    const Vec3 pushed = world.push_out(positions_[k], time);
    const Vec3 push = pushed - positions_[k];
    const double depth = length(push);
    if (depth <= 0) continue;
    const Vec3 n = push * (1 / depth);
    const Vec3 way = pushed - before_[k];
    positions_[k] = pushed - (way - n * dot(n, way)) * world.friction;
  }
  for (std::size_t i = 0; world.pin && i < columns_; ++i) positions_[at(i, 0)] = world.pin(i, time);
}

void Cloth::run(const ClothWorld& world, double begin, double end, double substep) {
  const auto count = static_cast<std::size_t>(std::ceil((end - begin) / substep - 1e-9));
  const double dt = (end - begin) / static_cast<double>(std::max<std::size_t>(count, 1));
  for (std::size_t s = 0; s < count; ++s) {
    check_cancelled();
    const double time = begin + dt * static_cast<double>(s + 1);
    add_forces(world, time, dt);
    before_ = positions_;
    for (std::size_t k = 0; k < positions_.size(); ++k) positions_[k] = positions_[k] + velocities_[k] * dt;
    solve(world, time, dt);
    for (std::size_t k = 0; k < positions_.size(); ++k)
      velocities_[k] = (positions_[k] - before_[k]) * (1 / dt);
  }
}

Vec3 Cloth::control(std::ptrdiff_t i, std::ptrdiff_t j) const {
  const auto columns = static_cast<std::ptrdiff_t>(columns_), rows = static_cast<std::ptrdiff_t>(rows_);
  if (closed_) i = (i + columns) % columns;
  if (i < 0) return control(0, j) * 2.0 - control(-i, j);
  if (i >= columns) return control(columns - 1, j) * 2.0 - control(2 * columns - 2 - i, j);
  if (j < 0) return control(i, 0) * 2.0 - control(i, -j);
  if (j >= rows) return control(i, rows - 1) * 2.0 - control(i, 2 * rows - 2 - j);
  return positions_[at(static_cast<std::size_t>(i), static_cast<std::size_t>(j))];
}

Vec3 Cloth::surface(double u, double v) const {
  const double x = u * static_cast<double>(closed_ ? columns_ : columns_ - 1);
  const double y = v * static_cast<double>(rows_ - 1);
  const auto i = static_cast<std::ptrdiff_t>(std::min(std::floor(x), static_cast<double>(columns_ - 1)));
  const auto j = static_cast<std::ptrdiff_t>(std::min(std::floor(y), static_cast<double>(rows_ - 1)));
  const std::array<double, 4> a = spline_weights(x - static_cast<double>(i));
  const std::array<double, 4> b = spline_weights(y - static_cast<double>(j));
  Vec3 sum;
  for (std::ptrdiff_t k = 0; k < 4; ++k) {
    for (std::ptrdiff_t l = 0; l < 4; ++l)
      sum = sum +
            control(i + k - 1, j + l - 1) * (a[static_cast<std::size_t>(k)] * b[static_cast<std::size_t>(l)]);
  }
  return sum;
}

}  // namespace stbvh::harness
