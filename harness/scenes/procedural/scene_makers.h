/// One function for each built-in scene. `scale` multiplies the triangle counts of the paper's table; step
/// counts stay. The same scale and seed give the same scene, bit by bit, on any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

Scene make_llama(double scale, std::uint64_t seed);
Scene make_barbershop(double scale, std::uint64_t seed);
Scene make_train(double scale, std::uint64_t seed);
Scene make_crowd(double scale, std::uint64_t seed);
Scene make_barbarian(double scale, std::uint64_t seed);
Scene make_barbarian_rotate(double scale, std::uint64_t seed);
Scene make_barbarian_rotate_with_steps(double scale, std::uint64_t seed, std::size_t steps);
Scene make_cloth(double scale, std::uint64_t seed);
/// One simulation whatever the number of steps: a step between two of its substeps lies on the line between.
Scene make_cloth_with_steps(double scale, std::uint64_t seed, std::size_t steps);
Scene make_wheels(double scale, std::uint64_t seed);
Scene make_dancer(double scale, std::uint64_t seed);
Scene make_static_city(double scale, std::uint64_t seed);
Scene make_torus(double scale, std::uint64_t seed);
Scene make_walker(double scale, std::uint64_t seed);
Scene make_cart(double scale, std::uint64_t seed);

}  // namespace stbvh::harness
