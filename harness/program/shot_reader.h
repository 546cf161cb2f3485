/// USD and Alembic files, by the libraries that read them best.
#pragma once

#include <optional>
#include <string>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

struct ShotOptions {
  /// Default: the range that the file names, or all of its samples.
  std::optional<FilePart> shutter;
  /// How far vertices may be from their true places, of the scene's diagonal.
  double largest_deviation = 1e-6;
};

/// Runs harness/scenes/shots/read_shot.py, which makes its Python environment when it has none yet, in a
/// process of its own: libraries may crash over malformed files. Throws SceneFileError, and Interrupted after
/// ctrl-C.
Scene read_shot(const std::string& name, const ShotOptions& options, const SceneWarning& warn);

}  // namespace stbvh::harness
