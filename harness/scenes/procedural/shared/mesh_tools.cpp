#include "harness/scenes/procedural/shared/mesh_tools.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stbvh::harness {
namespace {

void add_quad(Shape& shape, std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
  for (const std::size_t i : {a, b, c, a, c, d}) shape.indices.push_back(static_cast<std::uint32_t>(i));
}

/// Rows of `around` vertices on a closed ring, joined to one another.
void join_rings(Shape& shape, std::size_t first, std::size_t rings, std::size_t around) {
  for (std::size_t j = 0; j + 1 < rings; ++j) {
    for (std::size_t i = 0; i < around; ++i) {
      const std::size_t next = (i + 1) % around;
      const std::size_t row = first + j * around;
      add_quad(shape, row + i, row + next, row + around + next, row + around + i);
    }
  }
}

/// Fan over one ring, from its first vertex; `forward` chooses the side it faces.
void cap_ring(Shape& shape, std::size_t first, std::size_t around, bool forward) {
  for (std::size_t i = 1; i + 1 < around; ++i) {
    const std::size_t b = forward ? first + i : first + i + 1;
    const std::size_t c = forward ? first + i + 1 : first + i;
    for (const std::size_t v : {first, b, c}) shape.indices.push_back(static_cast<std::uint32_t>(v));
  }
}

/// Direction of the polyline at section i.
Vec3 tangent_at(const std::vector<TubeSection>& sections, std::size_t i) {
  const std::size_t before = i > 0 ? i - 1 : 0;
  const std::size_t after = std::min(i + 1, sections.size() - 1);
  return normalize(sections[after].center - sections[before].center);
}

}  // namespace

Quaternion align(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  a = normalize(a);
  c = normalize(c);
  const Vec3 axis = cross(a, c);
  const double sine = length(axis);
  const Quaternion first = axis_angle(sine > 1e-9 ? axis : perpendicular(a), std::atan2(sine, dot(a, c)));
  const Vec3 from = rotate(first, normalize(b - a * dot(a, b)));
  const Vec3 to = normalize(d - c * dot(c, d));
  return axis_angle(c, std::atan2(dot(c, cross(from, to)), dot(from, to))) * first;
}

Rigid operator*(const Rigid& a, const Rigid& b) {
  return {a.rotation * b.rotation, a.apply(b.translation)};
}

Rigid inverse(const Rigid& a) {
  const Quaternion q = conjugate(a.rotation);
  return {q, -rotate(q, a.translation)};
}

Rigid rotation_about(Vec3 pivot, Vec3 axis, double radians) {
  return translation(pivot) * rotation(axis, radians) * translation(-pivot);
}

std::size_t Shape::append(const Shape& other) {
  const std::size_t first = positions.size();
  positions.insert(positions.end(), other.positions.begin(), other.positions.end());
  indices.reserve(indices.size() + other.indices.size());
  for (const std::uint32_t i : other.indices) indices.push_back(i + static_cast<std::uint32_t>(first));
  return first;
}

void Shape::transform(const Rigid& motion) {
  for (Vec3& p : positions) p = motion.apply(p);
}

void Shape::stretch(Vec3 s) {
  for (Vec3& p : positions) p = {p.x * s.x, p.y * s.y, p.z * s.z};
}

Shape make_grid(std::size_t nu, std::size_t nv, const std::function<Vec3(double, double)>& f, Wrap wrap) {
  const std::size_t columns = wrap == Wrap::kNone ? nu + 1 : nu;
  const std::size_t rows = wrap == Wrap::kBoth ? nv : nv + 1;
  Shape shape;
  shape.positions.reserve(columns * rows);
  for (std::size_t j = 0; j < rows; ++j) {
    for (std::size_t i = 0; i < columns; ++i) {
      shape.positions.push_back(f(static_cast<double>(i) / static_cast<double>(nu),
                                  static_cast<double>(j) / static_cast<double>(nv)));
    }
  }
  shape.indices.reserve(6 * nu * nv);
  for (std::size_t j = 0; j < nv; ++j) {
    for (std::size_t i = 0; i < nu; ++i) {
      const std::size_t right = (i + 1) % columns;
      const std::size_t below = ((j + 1) % rows) * columns;
      add_quad(shape, j * columns + i, j * columns + right, below + right, below + i);
    }
  }
  return shape;
}

Shape make_tube(const std::vector<TubeSection>& sections, std::size_t around, Vec3 side, bool capped) {
  Shape shape;
  shape.positions.reserve(sections.size() * around);
  for (std::size_t j = 0; j < sections.size(); ++j) {
    const Vec3 along = tangent_at(sections, j);
    const Vec3 depth = normalize(cross(along, side));
    const Vec3 width = cross(depth, along);
    for (std::size_t i = 0; i < around; ++i) {
      const double angle = 2 * kPi * static_cast<double>(i) / static_cast<double>(around);
      shape.positions.push_back(sections[j].center + width * (std::cos(angle) * sections[j].half_width) +
                                depth * (std::sin(angle) * sections[j].half_depth));
    }
  }
  join_rings(shape, 0, sections.size(), around);
  if (capped && !sections.empty()) {
    cap_ring(shape, 0, around, false);
    cap_ring(shape, (sections.size() - 1) * around, around, true);
  }
  return shape;
}

Shape make_capsule(Vec3 a, Vec3 b, double radius_a, double radius_b, std::size_t around, std::size_t along) {
  const Vec3 axis = normalize(b - a);
  const std::size_t dome = std::max<std::size_t>(around / 4, 2);
  std::vector<TubeSection> sections;
  for (std::size_t k = 0; k < dome; ++k) {
    const double angle = 0.5 * kPi * (static_cast<double>(k) + 0.2) / static_cast<double>(dome);
    const double r = radius_a * std::sin(angle);
    sections.push_back({a - axis * (radius_a * std::cos(angle)), r, r});
  }
  for (std::size_t k = 0; k <= along; ++k) {
    const double f = static_cast<double>(k) / static_cast<double>(std::max<std::size_t>(along, 1));
    const double r = lerp(radius_a, radius_b, f);
    sections.push_back({lerp(a, b, f), r, r});
  }
  for (std::size_t k = dome; k-- > 0;) {
    const double angle = 0.5 * kPi * (static_cast<double>(k) + 0.2) / static_cast<double>(dome);
    const double r = radius_b * std::sin(angle);
    sections.push_back({b + axis * (radius_b * std::cos(angle)), r, r});
  }
  return make_tube(sections, around, perpendicular(axis));
}

Shape make_box(Vec3 center, Vec3 half, std::size_t n) {
  Shape box;
  // Each face: outward normal, and two axes whose cross product it is.
  struct Face {
    Vec3 normal, u, v;
  };
  constexpr std::array<Face, 6> kFaces{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                        {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                        {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}},
                                        {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
                                        {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
                                        {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}}};
  for (const Face& face : kFaces) {
    box.append(make_grid(
        n, n, [&](double u, double v) { return face.normal + face.u * (2 * u - 1) + face.v * (2 * v - 1); }));
  }
  box.stretch(half);
  box.transform(translation(center));
  return box;
}

Shape make_revolution(const std::vector<ProfilePoint>& profile, std::size_t around) {
  Shape shape;
  shape.positions.reserve(profile.size() * around);
  for (const ProfilePoint& point : profile) {
    for (std::size_t i = 0; i < around; ++i) {
      const double angle = -2 * kPi * static_cast<double>(i) / static_cast<double>(around);
      shape.positions.push_back(
          {point.radius * std::cos(angle), point.height, point.radius * std::sin(angle)});
    }
  }
  join_rings(shape, 0, profile.size(), around);
  return shape;
}

Shape make_ellipsoid(Vec3 half, std::size_t around, std::size_t rings) {
  std::vector<ProfilePoint> profile;
  for (std::size_t k = 0; k < rings; ++k) {
    // The poles stay open by a hair, so that no triangle has zero area.
    const double angle = kPi * (0.002 + 0.996 * static_cast<double>(k) / static_cast<double>(rings - 1));
    profile.push_back({std::sin(angle), -std::cos(angle)});
  }
  Shape shape = make_revolution(profile, around);
  shape.stretch(half);
  return shape;
}

void add_mesh(Scene& scene, Mesh&& mesh) {
  if (!mesh.indices.empty()) scene.meshes.push_back(std::move(mesh));
}

std::size_t detail(std::size_t full, std::size_t least, std::size_t triangles, double full_triangles) {
  const double share = std::sqrt(static_cast<double>(triangles) / full_triangles);
  return std::clamp(static_cast<std::size_t>(share * static_cast<double>(full)), least, full);
}

Mesh make_static_mesh(std::string name, const Shape& shape, Vec3f color) {
  return animate(std::move(name), shape, 1, color, [](Vec3 p, std::size_t, double) { return p; });
}

}  // namespace stbvh::harness
