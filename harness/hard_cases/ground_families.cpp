/// Large triangles, and rays whose distance from them is small against their size: a ground, and what stands
/// on it.
#include <cmath>
#include <limits>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"
#include "harness/oracle/oracle.h"
#include "harness/rays/ray_sources.h"

namespace stbvh::harness {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kSteps = 3;

/// A frame whose axes are the world's, in another order and with other signs: up is any of six.
struct Frame {
  std::size_t up = 1;
  double sign = 1;

  /// From a point given as right, up, forward.
  Vec3 operator()(Vec3 p) const {
    if (up == 0) return {sign * p.y, p.z, p.x};
    if (up == 1) return {p.x, sign * p.y, p.z};
    return {p.z, p.x, sign * p.y};
  }
};

Frame frame(std::size_t i) {
  return {i % 3, i / 3 % 2 == 0 ? 1.0 : -1.0};
}

/// How a ground moves; itself it stays where it is.
enum class Motion { kNone, kStands, kSlides };

/// Corners that slide along the ground, if asked to, over all steps.
Mesh moving(const Shape& shape, Motion motion, const Frame& frame, double reach) {
  Mesh mesh;
  mesh.indices = shape.indices;
  const std::size_t steps = motion == Motion::kNone ? 1 : kSteps;
  for (std::size_t step = 0; step < steps; ++step) {
    const double way = motion == Motion::kSlides ? reach * static_cast<double>(step) : 0;
    VertexBuffer& buffer = mesh.steps.emplace_back(shape.positions.size());
    for (std::size_t i = 0; i < shape.positions.size(); ++i) {
      buffer[i] = to_float(frame(shape.positions[i] + Vec3{way, 0, 0.3 * way}));
    }
  }
  return mesh;
}

/// Two triangles over [-size, size]^2, at a height.
Shape ground_shape(double size, double height) {
  return {.positions = {{-size, height, -size},
                        {size, height, -size},
                        {size, height, size},
                        {-size, height, size}},
          .indices = {0, 1, 2, 0, 2, 3}};
}

/// A box of twelve triangles.
Shape box_shape(Vec3 lower, Vec3 upper) {
  Shape box;
  for (unsigned i = 0; i < 8; ++i) {
    box.positions.push_back({(i & 1) != 0 ? upper.x : lower.x, (i & 2) != 0 ? upper.y : lower.y,
                             (i & 4) != 0 ? upper.z : lower.z});
  }
  box.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return box;
}

/// Upwards; every fourth is nearly level, every fourth goes along an axis as nearly as it may.
Vec3 upward(Pcg32& random) {
  Vec3 d = random_direction(random);
  d.y = std::abs(d.y);
  const double kind = random.uniform();
  if (kind < 0.25) d.y *= std::pow(10.0, -random.uniform(1, 6));
  if (kind > 0.75) d.x = 0;
  if (kind > 0.875) d.z = 0;
  if (d.y == 0) d.y = 1e-3;
  return normalize(d);
}

/// Cases in one frame after the other. begin(i, frame, case) makes the scene of case i and returns what makes
/// ray k of its share of `count` rays.
template <class Begin>
std::vector<HardCase> in_frames(std::size_t case_count, std::size_t count, const Begin& begin) {
  std::vector<HardCase> cases(case_count);
  for (std::size_t i = 0; i < case_count; ++i) {
    const auto ray = begin(i, frame(i), cases[i]);
    for (std::size_t k = share(count, i, case_count); k > 0; --k) cases[i].rays.push_back(ray(k));
  }
  return cases;
}

// The ground ----------------------------------------------------------------------------------------------

/// One ground in each of six frames, at rest, moving along itself, and with steps that are all alike.
std::vector<HardCase> grounds(double size, std::size_t count, std::uint64_t seed) {
  constexpr double kHeights[] = {0, 0, 1e-4, 1e-3, 1e-2};
  Pcg32 random(seed, 60);
  return in_frames(18, count, [&](std::size_t i, const Frame& turned, HardCase& made) {
    const Motion motion = static_cast<Motion>(i / 6);
    made.scene = one_mesh(moving(ground_shape(size, 0), motion, turned, 0.01 * size));
    // Something to hit, far above.
    made.scene.meshes.push_back(moving(ground_shape(0.3 * size, 0.5 * size), motion, turned, 0));
    return [&, turned](std::size_t k) {
      const Vec3 across = 0.9 * random_point(random, size);
      const Vec3 origin{across.x, kHeights[k % std::size(kHeights)], across.z};
      const Vec3 target = turned(upward(random));
      return make_ray(turned(origin), target, kInfinity, random_time(random));
    };
  });
}

// Flat boxes ----------------------------------------------------------------------------------------------

/// Rays from above a box of height 2 that go up, or from inside, where every one must hit.
std::vector<HardCase> slabs(double size, std::size_t count, std::uint64_t seed) {
  constexpr std::size_t kCases = 12;
  Pcg32 random(seed, 61);
  const Shape box = box_shape({-size, -1, -size}, {size, 1, size});
  return in_frames(kCases, count, [&](std::size_t i, const Frame& turned, HardCase& made) {
    const bool is_inside = i >= kCases / 2;
    made.scene = one_mesh(moving(box, static_cast<Motion>(i % 3), turned, 0.01 * size));
    made.expected = is_inside ? Expected::kClosed : Expected::kOracle;
    return [&, turned, is_inside](std::size_t) {
      const Vec3 across = 0.9 * random_point(random, size);
      const double above = 1 + std::pow(10.0, -random.uniform(1, 4));
      const Vec3 origin{across.x, is_inside ? 0.9 * random_point(random, 1).y : above, across.z};
      const Vec3 direction = is_inside ? random_direction(random) : upward(random);
      return make_ray(turned(origin), turned(direction), kInfinity, random_time(random));
    };
  });
}

// Large triangles in any direction ------------------------------------------------------------------------

/// Of about `size`, in front of each other.
Scene large_triangles(std::size_t triangles, double size, Pcg32& random) {
  return one_mesh(make_soup(triangles, kSteps - 1, random, [size](Pcg32& r) {
    return drifting(random_corners(r, random_point(r, size), size), 0.1 * size, r);
  }));
}

/// Rays that meet large triangles at angles of 1e-1 to 1e-6.
std::vector<HardCase> grazing(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 62);
  HardCase result{.scene = large_triangles(40, 1e4, random)};
  const Mesh& mesh = result.scene.meshes.front();
  while (result.rays.size() < count) {
    const std::size_t prim = result.rays.size() % mesh.triangle_count();
    const float time = random_time(random);
    const auto p = triangle_at(mesh, prim, motion_sample(mesh, time));
    const Vec3 normal = normalize(cross(p[1] - p[0], p[2] - p[0]));
    const Vec3 target = point_on(mesh, prim, time, Place::kInside, random);
    const Vec3 along = normalize(cross(normal, random_direction(random)));
    const Vec3 way = along + normal * std::pow(10.0, -random.uniform(1, 6));
    result.rays.push_back(aimed_ray(target - way * random.uniform(1, 1e4), target, time));
  }
  return one_case(std::move(result));
}

/// A small body on a huge ground that is turned anyhow: the ground's triangles and the body's share leaves.
Scene object_on_ground(double size, const Frame& turned, Motion motion) {
  Scene scene = one_mesh(moving(ground_shape(size, 0), motion, turned, 0.5));
  scene.meshes.push_back(moving(box_shape({-1, 0, -1}, {1, 2, 1}), motion, turned, 0.5));
  return scene;
}

/// Shadow rays of the body and of the ground around it, from points of their surfaces.
std::vector<HardCase> object_shadows(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 63);
  return in_frames(6, count, [&](std::size_t i, const Frame& turned, HardCase& made) {
    made.scene = object_on_ground(1e6, turned, static_cast<Motion>(i % 3));
    return [&, turned](std::size_t k) {
      const Mesh& body = made.scene.meshes[1];
      const float time = random_time(random);
      const Vec3 up = turned(upward(random));
      Vec3 origin;
      if (k % 2 == 0) {
        const std::size_t prim = k / 2 % body.triangle_count();
        origin = point_on(body, prim, time, Place::kInside, random) * (1 + 1e-4);
      } else {
        const Vec3 across = random_point(random, 3);
        origin = turned({across.x, k % 4 == 1 ? 0 : 1e-4, across.z});
      }
      return make_ray(origin, up, kInfinity, time);
    };
  });
}

/// A huge triangle and seven small ones over the same few vertices, seen from near the small ones.
std::vector<HardCase> huge_beside_small(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 64);
  Shape fan{.positions = {{0, 0, 0}, {1e6, 3e5, 2e5}, {-4e5, 1e5, 1e6}}, .indices = {0, 1, 2}};
  for (std::uint32_t i = 0; i < 5; ++i) {
    const double angle = 2 * kPi * i / 5;
    fan.positions.push_back({std::cos(angle), 0.5 + 0.2 * i, std::sin(angle)});
    fan.indices.insert(fan.indices.end(), {0, 3 + i, 3 + (i + 1) % 5});
  }
  return one_case(seen_from(one_mesh(moving(fan, Motion::kSlides, {}, 0.1)), {}, 3, count, random));
}

/// Triangles in planes across the axes, and rays from points of exactly these planes.
std::vector<HardCase> planes_through_origin(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 65);
  return in_frames(6, count, [&](std::size_t, const Frame& turned, HardCase& made) {
    std::vector<double> heights;
    for (const double size : {1.0, 1e3, 1e6}) {
      heights.push_back(to_float(random_point(random, size)).y);
      made.scene.meshes.push_back(
          moving(ground_shape(1e6, heights.back()), static_cast<Motion>(heights.size() - 1), turned, 10));
    }
    return [&random, turned, heights](std::size_t k) {
      const Vec3 across = random_point(random, 9e5);
      const Vec3 origin{across.x, heights[k % heights.size()], across.z};
      const Vec3 direction = upward(random) * (k % 2 == 0 ? 1.0 : -1.0);
      return make_ray(turned(origin), turned(direction), kInfinity, random_time(random));
    };
  });
}

// Rays that leave from where another hit ------------------------------------------------------------------

/// How a renderer finds the point that its next ray starts from.
enum class HitPoint {
  kRounded,   ///< the exact point, rounded once
  kStepped,   ///< o + t d, in float
  kWeighted,  ///< (1 - u - v) p0 + u p1 + v p2 of the moved vertices, in float
};

Vec3f hit_point(HitPoint how, const Mesh& mesh, const Ray& ray, const OracleAnswer& hit) {
  const auto p = triangle_at(mesh, hit.prim_id, motion_sample(mesh, ray.time));
  if (how == HitPoint::kRounded) {
    return to_float(p[0] * (1 - hit.u - hit.v) + p[1] * hit.u + p[2] * hit.v);
  }
  if (how == HitPoint::kStepped) {
    const Vec3f o = ray.origin;
    const Vec3f d = ray.direction;
    const auto t = static_cast<float>(hit.t);
    return {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
  }
  const Vec3f a = to_float(p[0]), b = to_float(p[1]), c = to_float(p[2]);
  const auto u = static_cast<float>(hit.u), v = static_cast<float>(hit.v);
  const float w = 1 - u - v;
  return {w * a.x + u * b.x + v * c.x, w * a.y + u * b.y + v * c.y, w * a.z + u * b.z + v * c.z};
}

/// From hits of large triangles, without any offset, on the side that the first ray came from.
std::vector<HardCase> leaving_large(HitPoint how, std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed, 66);
  HardCase result{.scene = large_triangles(40, 1e3, random)};
  const Mesh& mesh = result.scene.meshes.front();
  const Oracle oracle(result.scene);
  while (result.rays.size() < count) {
    const float time = random_time(random);
    const std::size_t prim = result.rays.size() % mesh.triangle_count();
    const Vec3 target = point_on(mesh, prim, time, Place::kInside, random);
    const Ray ray = aimed_ray(random_point(random, 3e3), target, time);
    const OracleAnswer hit = oracle.answer(ray);
    if (!hit.is_hit) continue;
    const auto p = triangle_at(mesh, hit.prim_id, motion_sample(mesh, time));
    Vec3 normal = normalize(cross(p[1] - p[0], p[2] - p[0]));
    if (dot(normal, to_double(ray.direction)) > 0) normal = -normal;
    Ray next = ray;
    next.origin = hit_point(how, mesh, ray, hit);
    next.direction = to_float(normalize(normal + random_direction(random) * 0.9999));
    result.rays.push_back(next);
    result.leaving.push_back({hit.geom_id, hit.prim_id});
  }
  return one_case(std::move(result));
}

/// The number as a power of ten: ground-1e4.
std::string power(std::string_view name, int exponent) {
  return std::string(name) + "-1e" + std::to_string(exponent);
}

}  // namespace

void add_ground_families(std::vector<HardFamily>& families) {
  for (int exponent = 1; exponent <= 6; ++exponent) {
    families.push_back(
        {.name = power("ground", exponent),
         .description = "Rays that leave a ground of two triangles upwards, from it or near above.",
         .make = [size = std::pow(10.0, exponent)](std::size_t count, std::uint64_t seed) {
           return grounds(size, count, seed);
         }});
  }
  for (int exponent = 6; exponent <= 15; exponent += 3) {
    families.push_back(
        {.name = power("slab", exponent),
         .description = "A large box of height 2: rays that leave it upwards, and rays from inside.",
         .make = [size = std::pow(10.0, exponent)](std::size_t count, std::uint64_t seed) {
           return slabs(size, count, seed);
         }});
  }
  families.push_back({.name = "grazing-large",
                      .description = "Rays that meet triangles of size 1e4 at angles of 1e-1 to 1e-6.",
                      .make = grazing});
  families.push_back({.name = "object-on-ground",
                      .description = "Shadow rays of a small box on a ground a million times as large.",
                      .make = object_shadows});
  families.push_back({.name = "huge-beside-small",
                      .description = "A huge triangle and small ones that share a vertex, seen from nearby.",
                      .make = huge_beside_small});
  families.push_back({.name = "plane-through-origin",
                      .description = "Large triangles across the axes, and rays from points of their planes.",
                      .make = planes_through_origin});
  constexpr std::pair<const char*, HitPoint> kHitPoints[] = {
      {"rounded", HitPoint::kRounded}, {"stepped", HitPoint::kStepped}, {"weighted", HitPoint::kWeighted}};
  for (const auto& [name, how] : kHitPoints) {
    families.push_back({.name = "leaving-large-" + std::string(name),
                        .description = "From hit points of large triangles, without any offset.",
                        .make = [how = how](std::size_t count, std::uint64_t seed) {
                          return leaving_large(how, count, seed);
                        }});
  }
}

}  // namespace stbvh::harness
