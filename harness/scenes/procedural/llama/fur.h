/// Fur: thin, pointed, three-sided strands rooted in a skinned surface and moving with it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "harness/scenes/procedural/shared/skeleton.h"

namespace stbvh::harness {

/// What grows at a place of the rest surface.
struct FurAt {
  double length = 0;       ///< 0: none grows here
  double density = 1;      ///< relative, at most 1
  Vec3 combed{0, -1, 0};   ///< where the hair lies, in rest space
  double lift = 0.5;       ///< 0: flat along `combed`, 1: along the normal
  std::size_t colour = 0;  ///< index into FurSettings::colours
};

struct FurSettings {
  std::size_t strands = 0;
  std::size_t segments = 5;  ///< 6 segments - 3 triangles for each strand
  double root_radius = 0.001;
  double sway = 0.0;  ///< how far tips move by themselves, in lengths
  std::vector<Vec3f> colours;
  std::uint64_t seed = 1;
};

/// One mesh for each colour, over the steps of `transforms`.
std::vector<Mesh> grow_fur(const std::string& name, const SkinnedShape& skin, const FurSettings& settings,
                           const std::function<FurAt(Vec3 position, Vec3 normal)>& fur_at,
                           const std::vector<std::vector<Rigid>>& transforms);

}  // namespace stbvh::harness
