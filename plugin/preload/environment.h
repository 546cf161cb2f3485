/// What the environment variables STBVH_PRELOAD* ask for.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "stbvh/structure.h"

namespace stbvh::preload {

struct Environment {
  bool enabled = true;         ///< STBVH_PRELOAD
  bool all_triangles = false;  ///< STBVH_PRELOAD_ALL: all meshes of one step too
  bool verbose = false;        ///< STBVH_PRELOAD_VERBOSE: a line on stderr for each commit
  bool fast = false;           ///< STBVH_PRELOAD_PRESET=fast: Precision::kFast where scenes are not robust
  std::size_t max_bytes = kNoLimit;  ///< STBVH_PRELOAD_MAX_BYTES: of the structure of each scene
  /// STBVH_PRELOAD_STATISTICS: none; "": text on stderr; else the file that gets them as JSON.
  std::optional<std::string> statistics;
};

/// Takes the variables by name (null: not set). A value that is not understood leaves the default, and
/// `complain` is told in one sentence.
Environment read_environment(const std::function<const char*(const char*)>& variable,
                             const std::function<void(const std::string&)>& complain);

/// Of this process, read once; complaints go to stderr.
const Environment& environment();

}  // namespace stbvh::preload
