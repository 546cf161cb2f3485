// The patches of machine_parts.h.
#include <algorithm>
#include <cmath>

#include "harness/scenes/procedural/shared/machine_parts.h"

namespace stbvh::harness {
namespace {

/// Share of a radius that stays open where a surface would close in a point: no triangle of zero area.
constexpr double kPinhole = 2e-3;

/// Around the y axis, from angle 0 against the sense of rotation, so that outward profiles face outwards.
Vec3 around_y(ProfilePoint p, double turn) {
  const double angle = -2 * kPi * turn;
  return {p.radius * std::cos(angle), p.height, p.radius * std::sin(angle)};
}

Patches placed(Patches patches, const Rigid& pose) {
  for (Patch& patch : patches) {
    patch.at = [at = std::move(patch.at), pose](double u, double v) { return pose.apply(at(u, v)); };
  }
  return patches;
}

}  // namespace

Rigid along_axis(Vec3 origin, Vec3 axis) {
  const Vec3 to = normalize(axis);
  const double cosine = to.y;
  const Vec3 turn = cross(Vec3{0, 1, 0}, to);
  if (length(turn) < 1e-9) return {cosine > 0 ? Quaternion{} : axis_angle({1, 0, 0}, kPi), origin};
  return {axis_angle(normalize(turn), std::acos(std::clamp(cosine, -1.0, 1.0))), origin};
}

Patches quad(Vec3 p00, Vec3 p10, Vec3 p11, Vec3 p01) {
  return {{[=](double u, double v) { return lerp(lerp(p00, p10, u), lerp(p01, p11, u), v); },
           std::max(length(p10 - p00), length(p11 - p01)), std::max(length(p01 - p00), length(p11 - p10))}};
}

Patches box(Vec3 c, Vec3 h) {
  const auto corner = [=](double x, double y, double z) { return c + Vec3{x * h.x, y * h.y, z * h.z}; };
  return join({quad(corner(1, -1, -1), corner(1, 1, -1), corner(1, 1, 1), corner(1, -1, 1)),
               quad(corner(-1, -1, -1), corner(-1, -1, 1), corner(-1, 1, 1), corner(-1, 1, -1)),
               quad(corner(-1, 1, -1), corner(-1, 1, 1), corner(1, 1, 1), corner(1, 1, -1)),
               quad(corner(-1, -1, -1), corner(1, -1, -1), corner(1, -1, 1), corner(-1, -1, 1)),
               quad(corner(-1, -1, 1), corner(1, -1, 1), corner(1, 1, 1), corner(-1, 1, 1)),
               quad(corner(-1, -1, -1), corner(-1, 1, -1), corner(1, 1, -1), corner(1, -1, -1))});
}

Patches lathe(const std::vector<ProfilePoint>& profile, std::size_t around) {
  Patches patches;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const ProfilePoint a = profile[i], b = profile[i + 1];
    const double widest = std::max(a.radius, b.radius);
    const auto radius = [least = kPinhole * widest](double r) { return std::max(r, least); };
    patches.push_back(
        {[=](double u, double v) {
           return around_y({radius(lerp(a.radius, b.radius, v)), lerp(a.height, b.height, v)}, u);
         },
         2 * kPi * widest, std::hypot(a.radius - b.radius, a.height - b.height), around, 1, Wrap::kU});
  }
  return patches;
}

Patches smooth_lathe(const std::function<ProfilePoint(double)>& profile, double radius, double length,
                     std::size_t around, std::size_t along) {
  return {{[=](double u, double v) {
             ProfilePoint p = profile(v);
             p.radius = std::max(p.radius, kPinhole * radius);
             return around_y(p, u);
           },
           2 * kPi * radius, length, around, along, Wrap::kU}};
}

Patches ellipsoid(Vec3 center, Vec3 half, std::size_t around, std::size_t along) {
  const double widest = std::max(half.x, half.z);
  return {{[=](double u, double v) {
             const double angle = kPi * (kPinhole + (1 - 2 * kPinhole) * v);
             const Vec3 p = around_y({std::sin(angle), -std::cos(angle)}, u);
             return center + Vec3{p.x * half.x, p.y * half.y, p.z * half.z};
           },
           2 * kPi * widest, kPi * std::max(half.y, 0.5 * widest), around, along, Wrap::kU}};
}

Patches disc(Vec3 center, Vec3 normal, double radius, std::size_t around) {
  return placed(lathe({{radius, 0}, {0, 0}}, around), along_axis(center, normal));
}

Patches cylinder(Vec3 a, Vec3 b, double radius_a, double radius_b, bool capped, std::size_t around) {
  const double height = length(b - a);
  std::vector<ProfilePoint> profile{{radius_a, 0}, {radius_b, height}};
  if (capped) {
    profile.insert(profile.begin(), {0, 0});
    profile.push_back({0, height});
  }
  return placed(lathe(profile, around), along_axis(a, b - a));
}

Patches torus(Vec3 center, Vec3 axis, double radius, double thickness, std::size_t around,
              std::size_t section) {
  Patch patch{[=](double u, double v) {
                const double angle = 2 * kPi * v;
                return around_y({radius + thickness * std::cos(angle), thickness * std::sin(angle)}, u);
              },
              2 * kPi * radius,
              2 * kPi * thickness,
              around,
              section,
              Wrap::kBoth};
  return placed({std::move(patch)}, along_axis(center, axis));
}

Patches tube(const std::function<Vec3(double)>& curve, double length, double radius, Vec3 side,
             std::size_t around, std::size_t along) {
  return {{[=](double u, double v) {
             constexpr double kStep = 1e-3;
             const Vec3 tangent =
                 normalize(curve(std::min(v + kStep, 1.0)) - curve(std::max(v - kStep, 0.0)));
             const Vec3 depth = normalize(cross(tangent, side));
             const Vec3 width = cross(depth, tangent);
             const double angle = 2 * kPi * u;
             return curve(v) + (width * std::cos(angle) + depth * std::sin(angle)) * radius;
           },
           2 * kPi * radius, length, around, along, Wrap::kU}};
}

Patches sheet(const std::function<Vec3(double, double)>& at, double length_u, double length_v,
              std::size_t min_u, std::size_t min_v) {
  return {{at, length_u, length_v, min_u, min_v}};
}

Patches join(std::initializer_list<Patches> groups) {
  Patches all;
  for (const Patches& group : groups) all.insert(all.end(), group.begin(), group.end());
  return all;
}

}  // namespace stbvh::harness
