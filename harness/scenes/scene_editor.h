/// Changes to a scene, as who works on it would make them one after another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string_view>
#include <vector>

#include "harness/scenes/pcg32.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// What of a mesh changed.
struct MeshEdit {
  enum class Extent { kMask, kPositions, kEverything };
  std::size_t mesh = 0;
  Extent extent = Extent::kEverything;
};

enum class EditKind {
  kMoved,     ///< a mesh is somewhere else, by up to a twentieth of the scene's diagonal
  kDeformed,  ///< all its vertices are, each by a little
  kAnimated,  ///< all meshes that move go on with their motion: the next frame of a simulation
  kReplaced,  ///< it has other triangles
  kHidden,    ///< it is gone, or there again
  kMasked,    ///< it has another mask
};
std::span<const std::string_view> edit_kind_names();

/// Makes random edits of a scene in place, the same ones for the same seed.
class SceneEditor {
 public:
  SceneEditor(Scene& scene, std::uint64_t seed);

  /// Which meshes were changed, and how. Meshes that move are chosen where there are any.
  std::vector<MeshEdit> apply(EditKind kind);

 private:
  std::size_t some_mesh();
  Vec3f some_offset(double most);
  MeshEdit moved(std::size_t mesh);
  MeshEdit deformed(std::size_t mesh);
  MeshEdit replaced(std::size_t mesh);
  MeshEdit hidden(std::size_t mesh);
  MeshEdit masked(std::size_t mesh);

  Scene& scene_;
  Pcg32 random_;
  double diagonal_;
  std::vector<std::size_t> meshes_;                              ///< that are edited
  std::map<std::size_t, std::vector<std::uint32_t>> triangles_;  ///< of those that have others, or none, now
};

}  // namespace stbvh::harness
