/// How many triangles with how many steps each scene has: the table of the paper (section 5) for its six
/// scenes.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace stbvh::harness {

/// Triangles that have `steps` steps, at scale 1.
struct StepGroup {
  std::size_t steps;
  double triangles;
};

/// Moving triangles of a scene with figures, by step count, at scale 1; static surroundings come on top
/// (few). Empty for other scenes.
std::span<const StepGroup> planned_groups(std::string_view scene);

/// Triangles with `steps` steps that `scene` has at `scale`; at least 64.
/// Throws std::invalid_argument for a scale that is not positive, or above kMaxScale.
std::size_t planned_triangles(std::string_view scene, std::size_t steps, double scale);

/// Beyond this, 32-bit vertex indices would run out in the largest scenes.
inline constexpr double kMaxScale = 64;

/// The scale at which such a scene has about that many moving triangles; it may be above kMaxScale.
double scale_for(std::string_view scene, std::size_t triangles);

/// How `triangles` of a crowd are dealt out.
struct CrowdPlan {
  std::size_t figures;
  std::size_t triangles_per_figure;
};
/// At large scales the number of figures grows, at small ones only their detail shrinks, down to a share of a
/// crowd.
CrowdPlan plan_crowd(std::size_t steps, double scale);

/// How the llama's triangles are dealt out.
struct LlamaPlan {
  std::size_t long_strands;    ///< 3 steps
  std::size_t body_triangles;  ///< 9 steps
  std::size_t short_strands;   ///< 9 steps, on face, ears and legs
};
LlamaPlan plan_llama(double scale);

/// Triangles of a strand with that many segments along it, three-sided and pointed.
constexpr std::size_t strand_triangles(std::size_t segments) {
  return 6 * segments - 3;
}
inline constexpr std::size_t kLongStrandSegments = 5;
inline constexpr std::size_t kShortStrandSegments = 3;

}  // namespace stbvh::harness
