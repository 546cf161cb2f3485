/// Rays at points that are chosen to hurt, and times to send them at.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "harness/hard_cases/bodies.h"
#include "harness/hard_cases/hard_case.h"

namespace stbvh::harness {

/// Where on a triangle a ray goes.
enum class Place { kInside, kEdge, kVertex };

/// Chooses the time of a ray, in [0, 1].
using TimeChoice = std::function<float(Pcg32&)>;

/// Uniform; in every fourth call exactly a step of `mesh`.
TimeChoice mixed_times(const Mesh& mesh);
/// A step of `mesh`, or one float beside it on either side, in [0, 1].
TimeChoice step_times(const Mesh& mesh);

/// `value`, or one float beside it.
float ulp_around(float value, Pcg32& random);

/// A point of triangle `prim` at `time`; its vertices are weighed in double, as the contract has them.
Vec3 point_on(const Mesh& mesh, std::size_t prim, float time, Place place, Pcg32& random);

/// From `origin`, rounded, through `target`: the direction is multiplied by a power of two, so that its
/// largest component is in [1, 2), and rounded once.
Ray aimed_ray(Vec3 origin, Vec3 target, float time);

/// The ray with one component of its direction moved by one float, either way.
Ray ulp_beside(Ray ray, Pcg32& random);

/// Rays at a random triangle of a random mesh of `scene`, at `place`s in turn, from `origin(time)`.
struct Aims {
  TimeChoice time;
  std::function<Vec3(float time, Pcg32&)> origin;
  std::vector<Place> places{Place::kInside, Place::kEdge, Place::kVertex};
  bool beside = false;  ///< every second ray goes one ulp beside its target
};
std::vector<Ray> rays_at(const Scene& scene, const Aims& aims, std::size_t count, Pcg32& random);

/// A closed body, which is `scene`'s only mesh, seen from near its centre: rays at vertices, edge points and
/// an ulp beside them.
HardCase inside_body(const Body& body, const TimeChoice& time, std::size_t count, Pcg32& random);
HardCase inside_body(const Body& body, std::size_t count, Pcg32& random);

/// `scene` seen from random points of a cube about `center`, at all places.
HardCase seen_from(Scene scene, Vec3 center, double extent, std::size_t count, Pcg32& random);

/// The share of case `i` among `cases` of `count` rays.
std::size_t share(std::size_t count, std::size_t i, std::size_t cases);

}  // namespace stbvh::harness
