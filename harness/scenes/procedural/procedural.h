/// The built-in scenes: deterministic by seed, at any scale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "harness/scenes/scene.h"

namespace stbvh::harness {

struct ProceduralScene {
  std::string_view name;
  std::string_view description;  ///< one line
  double default_scale;          ///< share of the triangles of the paper's table that a laptop holds easily
  Scene (*make)(double scale, std::uint64_t seed);
  /// The same motion with `steps` steps, 2 to kMaxSteps, of all that moves; null where not all of it has
  /// the same number.
  Scene (*make_with_steps)(double scale, std::uint64_t seed, std::size_t steps) = nullptr;
};

/// All built-in scenes, the six of the paper first.
std::span<const ProceduralScene> procedural_scenes();

/// By the name of a group: "paper" (its six), "large" (those and four more), "small" (trees that the caches
/// hold), "all"; else none.
std::span<const ProceduralScene> scene_group(std::string_view name);

/// The scene of that name, or null.
const ProceduralScene* find_procedural_scene(std::string_view name);

}  // namespace stbvh::harness
