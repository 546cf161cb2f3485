/// Needles, slivers, triangles without area, and triangles on top of each other.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSegments = 4;
constexpr std::size_t kTriangles = 1000;

/// One short edge and two long ones.
Corners needle(double aspect, Pcg32& random) {
  const Vec3 center = random_point(random, 1);
  const Vec3 along = random_point(random, 0.7);
  const Vec3 across = random_point(random, 0.7 / aspect);
  return {center - along, center + along, center + along + across};
}

/// Three long edges, nearly in one line.
Corners sliver(double aspect, Pcg32& random) {
  const Vec3 center = random_point(random, 1);
  const Vec3 along = random_point(random, 0.7);
  const Vec3 across = random_point(random, 0.7 / aspect);
  return {center - along, center + along, center + along * random.uniform(-0.8, 0.8) + across};
}

HardFamily thin_soup(std::string_view name, int power, Corners (*make)(double, Pcg32&)) {
  return {.name = fmt::format("{}-1e{}", name, power),
          .description =
              fmt::format("A soup of moving {} of aspect 1e{}; rays at points inside them.", name, power),
          .make = [power, make](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 20);
            const auto triangle = [&](Pcg32& r) { return drifting(make(std::pow(10.0, power), r), 0.3, r); };
            HardCase result{.scene = one_mesh(make_soup(kTriangles, kSegments, random, triangle))};
            const Aims aims{.time = mixed_times(result.scene.meshes.front()),
                            .origin = [](float, Pcg32& r) { return random_point(r, 2.5); },
                            .places = {Place::kInside}};
            result.rays = rays_at(result.scene, aims, count, random);
            return one_case(std::move(result));
          }};
}

HardFamily needle_body(int power) {
  return {.name = fmt::format("closed-needles-1e{}", power),
          .description = fmt::format("A closed body stretched 1e{} times, seen from inside.", power),
          .make = [power](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 21);
            const Body body{.segments = kSegments, .stretch = {std::pow(10.0, power), 1, 1}};
            return one_case(inside_body(body, count, random));
          }};
}

/// What a soup's triangles become; called with the triangle's number.
using Spoil = std::function<MovingCorners(std::size_t number, const MovingCorners& sound)>;

HardFamily spoilt_soup(std::string_view name, std::string_view description, const Spoil& spoil) {
  return {.name = std::string(name),
          .description = std::string(description),
          .make = [spoil](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 22);
            std::size_t number = 0;
            const auto triangle = [&](Pcg32& r) {
              return spoil(number++, bending(random_corners(r, random_point(r, 1), 0.3), 0.1, r));
            };
            Scene scene = one_mesh(make_soup(kTriangles, kSegments, random, triangle));
            return one_case(seen_from(std::move(scene), {}, 2.5, count, random));
          }};
}

/// Two of three triangles collapsed: to a line, or to a point.
MovingCorners without_area(std::size_t number, const MovingCorners& sound) {
  return [=](double time) {
    Corners p = sound(time);
    if (number % 3 == 1) p[2] = lerp(p[0], p[1], 0.25);
    if (number % 3 == 2) p[1] = p[2] = p[0];
    return p;
  };
}

/// Collapsed at the step in the middle of the shutter only.
MovingCorners without_area_once(std::size_t number, const MovingCorners& sound) {
  return [=](double time) {
    Corners p = sound(time);
    if (time != 0.5) return p;
    if (number % 2 == 0) p[2] = p[0];
    if (number % 2 == 1) p[1] = p[2] = p[0];
    return p;
  };
}

/// Two corners change places from each step to the next.
MovingCorners turning_inside_out(std::size_t, const MovingCorners& sound) {
  return [=](double time) {
    Corners p = sound(time);
    if (static_cast<int>(std::lround(time * kSegments)) % 2 == 1) std::swap(p[1], p[2]);
    return p;
  };
}

/// Each triangle twice in its mesh, corners in another order, and the whole mesh twice.
std::vector<HardCase> duplicates(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 23);
  Mesh mesh = make_sheet(16, kSegments, 1, {});
  const std::vector<std::uint32_t> once = mesh.indices;
  for (std::size_t i = 0; i < once.size(); i += 3) {
    mesh.indices.insert(mesh.indices.end(), {once[i + 1], once[i + 2], once[i]});
  }
  Scene scene = one_mesh(mesh);
  scene.meshes.push_back(std::move(mesh));
  return one_case(seen_from(std::move(scene), {0, 3, 0}, 1, count, random));
}

/// Overlapping triangles in a few common planes that move as a whole.
std::vector<HardCase> coplanar(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 24);
  std::size_t number = 0;
  const auto triangle = [&](Pcg32& r) -> MovingCorners {
    Corners p = random_corners(r, random_point(r, 1), 0.5);
    const double plane = static_cast<double>(number++ % 4);
    for (Vec3& corner : p) corner.z = 0.4 * plane + 0.3 * corner.x - 0.2 * corner.y;
    return [=](double time) {
      const Vec3 shift{0, 0, 0.5 * time};
      return Corners{p[0] + shift, p[1] + shift, p[2] + shift};
    };
  };
  Scene scene = one_mesh(make_soup(kTriangles, kSegments, random, triangle));
  return one_case(seen_from(std::move(scene), {0, 0, 4}, 1, count, random));
}

}  // namespace

void add_thin_families(std::vector<HardFamily>& families) {
  for (int power = 4; power <= 7; ++power) families.push_back(thin_soup("needles", power, needle));
  for (int power = 4; power <= 7; ++power) families.push_back(thin_soup("slivers", power, sliver));
  for (const int power : {4, 6}) families.push_back(needle_body(power));
  families.push_back(
      spoilt_soup("zero-area", "A soup in which two of three triangles have no area.", without_area));
  families.push_back(spoilt_soup("zero-area-once",
                                 "A soup whose triangles have no area at one step, in the middle.",
                                 without_area_once));
  families.push_back(spoilt_soup("inside-out", "A soup whose triangles turn inside out in each segment.",
                                 turning_inside_out));
  families.push_back(
      {.name = "duplicates", .description = "A sheet with every triangle four times.", .make = duplicates});
  families.push_back({.name = "coplanar",
                      .description = "Triangles that overlap in a few common planes.",
                      .make = coplanar});
}

}  // namespace stbvh::harness
