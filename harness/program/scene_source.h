/// Scenes by name or file.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/program/scene_options.h"
#include "harness/report/records.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// A scene that was asked for, not loaded yet.
struct SceneSource {
  std::string name;
  std::function<Scene()> load;  ///< throws UsageError or SceneFileError
};

/// Throws UsageError for a name that is neither a built-in scene nor a .glb, .gltf, .xml, .ecs or .stbvh
/// file, no USD or Alembic file that exists, and SceneFileError for OBJ files that make no sequence.
SceneSource find_scene(const std::string& name, const MakingOptions& making);

/// All scenes of `options`, likewise.
std::vector<SceneSource> find_scenes(const SceneOptions& options);

/// `scene`, named `name`. Throws UsageError for what no ray can be sent through.
Scene checked(Scene scene, const std::string& name);

SceneSummary summarize(const Scene& scene);

/// `scene` as structures get it: with other steps, and with the tolerance (of its diagonal) and the bytes
/// that they may take; of a share of embree's, `embree` is built for that.
Scene handed_over(Scene scene, const Resampling& resampling, double tolerance, const MemoryBudget& budget);

}  // namespace stbvh::harness
