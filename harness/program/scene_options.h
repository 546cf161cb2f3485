/// How the command lines of all programs say which scene, and how it is made. The options are checked as they
/// are read: UsageError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "harness/scenes/gltf/gltf.h"
#include "harness/scenes/resampled.h"

namespace CLI {
class App;
}

namespace stbvh::harness {

/// Bytes that structures may take: as many, or a share of those that `embree` takes; none: no limit.
struct MemoryBudget {
  std::optional<std::size_t> bytes;
  std::optional<double> share;
};

/// Steps that every mesh is handed over with.
struct Resampling {
  std::size_t steps = 0;  ///< 0: as they are
  StepPlaces places = StepPlaces::kEquidistant;
};

/// A line on stderr for what a scene is shown without.
void print_warning(const std::string& sentence);

/// How scenes are made.
struct MakingOptions {
  std::optional<double> scale;  ///< of built-in scenes; empty: each scene's default
  std::uint64_t seed = 1;
  GltfOptions gltf;
  std::size_t obj_step = 1;  ///< by which the numbers of OBJ sequences go up
  Resampling resampling;
  double tolerance = 0;    ///< of structures that can, of the scene's diagonal
  MemoryBudget max_bytes;  ///< of the same
  /// Is told what of a file is left out.
  SceneWarning warn = print_warning;
  /// Those of these options, and --scenes, that were given, for another command.
  std::vector<std::string> scene_words;
};

/// Names of built-in scenes, and files: each of `asked` once, with groups (scene_group) replaced by the
/// scenes they stand for.
std::vector<std::string> named_scenes(const std::vector<std::string>& asked);

struct SceneOptions : MakingOptions {
  std::vector<std::string> scenes = named_scenes({"paper"});
};

/// --scale.
void add_scale_option(CLI::App& app, std::optional<double>& scale);

/// --resample-steps.
void add_resampling_option(CLI::App& app, Resampling& resampling);

/// --tolerance, of a scene's diagonal.
void add_tolerance_option(CLI::App& app, double& tolerance);

/// --max-bytes.
void add_max_bytes_option(CLI::App& app, MemoryBudget& budget);

/// How a scene is made that is named elsewhere: --scale, --seed and those of files.
void add_making_options(CLI::App& app, MakingOptions& making);

/// --scenes, and how these are made.
void add_scene_options(CLI::App& app, SceneOptions& scenes);

/// `word` as a shell takes it for one.
std::string shell_word(const std::string& word);

}  // namespace stbvh::harness
