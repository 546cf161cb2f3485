/// Boxes without extent, rays in the planes of triangles, directions at the ends of what floats hold.
#include <array>
#include <cmath>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"
#include "harness/rays/ray_generator.h"
#include "harness/rays/ray_sources.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kTriangles = 600;
constexpr std::size_t kSegments = 4;

double& component(Vec3& v, std::size_t axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

float& component(Vec3f& v, std::size_t axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// On a lattice of eighths, in [-1, 1].
double lattice(Pcg32& random) {
  return std::floor(random.uniform() * 17) / 8 - 1;
}

/// Triangles exactly in planes axis = constant, on a lattice, that move within their plane.
Mesh make_flat(std::size_t segments, Pcg32& random) {
  std::size_t number = 0;
  return make_soup(kTriangles, segments, random, [&](Pcg32& r) -> MovingCorners {
    const std::size_t axis = number++ % 3;
    Corners p;
    const double plane = lattice(r);
    for (Vec3& corner : p) {
      corner = {lattice(r), lattice(r), lattice(r)};
      component(corner, axis) = plane;
    }
    const double way = lattice(r);
    return [=](double time) {
      Corners moved = p;
      for (Vec3& corner : moved) component(corner, (axis + 1) % 3) += way * time;
      return moved;
    };
  });
}

/// Moving triangles, and still ones if asked for.
Scene flat_scene(bool with_still, Pcg32& random) {
  Scene scene = one_mesh(make_flat(kSegments, random));
  if (with_still) scene.meshes.push_back(make_flat(0, random));
  return scene;
}

std::vector<HardCase> flat_boxes(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 30);
  return one_case(seen_from(flat_scene(false, random), {}, 3, count, random));
}

/// Rays at lattice points, some of whose components are small; from lattice points too, so that many lie in
/// the plane of a triangle.
std::vector<Ray> rays_along_axes(std::size_t count, const std::vector<float>& small, Pcg32& random) {
  std::vector<Ray> rays;
  while (rays.size() < count) {
    Ray ray = aimed_ray({3 * lattice(random), 3 * lattice(random), 3 * lattice(random)},
                        {lattice(random), lattice(random), lattice(random)}, random_time(random));
    if (random.uniform() < 0.5) ray.origin = to_float(random_point(random, 3));
    const std::size_t spoilt = 1 + rays.size() % 2;
    const auto first = static_cast<std::size_t>(random.uniform() * 3);
    for (std::size_t i = 0; i < spoilt; ++i) {
      component(ray.direction, (first + i) % 3) =
          small[static_cast<std::size_t>(random.uniform() * static_cast<double>(small.size()))];
    }
    const std::size_t kept = (first + 2) % 3;
    if (component(ray.direction, kept) == 0) component(ray.direction, kept) = 1.0f;
    rays.push_back(ray);
  }
  return rays;
}

HardFamily along_axes(std::string_view name, std::string_view description, bool with_still,
                      std::vector<float> small) {
  return {.name = std::string(name),
          .description = std::string(description),
          .askable = with_still ? Askable::kOurs : Askable::kAll,
          .make = [with_still, small](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 31);
            HardCase result{.scene = flat_scene(with_still, random)};
            result.rays = rays_along_axes(count, small, random);
            return one_case(std::move(result));
          }};
}

/// Rays whose direction lies in the plane of a triangle, from points of that plane.
std::vector<HardCase> in_plane(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 32);
  HardCase result{.scene = flat_scene(false, random)};
  while (result.rays.size() < count) {
    const std::size_t axis = result.rays.size() % 3;
    Vec3 origin = random_point(random, 2);
    Vec3 target = random_point(random, 1);
    component(origin, axis) = component(target, axis) = lattice(random);
    result.rays.push_back(aimed_ray(origin, target, random_time(random)));
  }
  return one_case(std::move(result));
}

/// Directions of lengths between 10^lower and 10^upper.
HardFamily lengths(std::string_view name, std::string_view description, Askable askable, double lower,
                   double upper) {
  return {.name = std::string(name),
          .description = std::string(description),
          .askable = askable,
          .make = [lower, upper](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 33);
            HardCase result = seen_from(one_mesh(make_body({.segments = kSegments})), {}, 3, count, random);
            for (Ray& ray : result.rays) {
              const double length = std::pow(10.0, random.uniform(lower, upper));
              const Vec3f d = ray.direction;
              ray.direction = to_float(Vec3{d.x, d.y, d.z} * length);
            }
            return one_case(std::move(result));
          }};
}

}  // namespace

void add_flat_families(std::vector<HardFamily>& families) {
  families.push_back({.name = "flat-boxes",
                      .description = "Triangles in axis-aligned planes, whose boxes have no extent.",
                      .make = flat_boxes});
  families.push_back(
      {.name = "in-plane", .description = "Rays within the planes of such triangles.", .make = in_plane});
  const std::vector<float> zeros{0.0f, -0.0f};
  const std::vector<float> denormals{0x1p-149f, -0x1p-127f, 1e-40f, 1e-30f, -1e-20f, 1e-7f};
  families.push_back(along_axes("zero-directions",
                                "Such triangles; one or two components of the direction are 0 or -0.", false,
                                zeros));
  families.push_back(along_axes("denormal-directions",
                                "The same with one or two components denormal, or next to nothing.", false,
                                denormals));
  // Embree 3.13.5 finds t = NaN in one of its two trees, and asserts that it is none in the other.
  families.push_back(along_axes("zero-directions-still",
                                "Components of 0 or -0 where some of the triangles stand still.", true,
                                zeros));
  families.push_back(along_axes("denormal-directions-still",
                                "Denormal components where some of the triangles stand still.", true,
                                denormals));
  families.push_back(
      lengths("direction-lengths", "Directions of lengths from 1e-20 to 1e17.", Askable::kAll, -20, 17));
  families.push_back(lengths("direction-lengths-1e20",
                             "Directions of lengths from 1e17 to 1e20, on which Embree asserts.",
                             Askable::kDirect, 17, 20));
}

}  // namespace stbvh::harness
