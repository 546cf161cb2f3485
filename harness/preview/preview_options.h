/// What stbvh-preview was asked for.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "harness/preview/preview_model.h"

namespace stbvh::harness {

struct PreviewOptions : ModelOptions {
  std::string scene = "cloth";
  std::size_t width = 1280, height = 800;
  std::size_t most_samples = 4096;
  std::optional<std::filesystem::path> screenshot;
  std::size_t frames = 30;  ///< after which the screenshot is taken
  std::optional<std::filesystem::path> script;
  bool prints_statistics = false;
};

/// Empty if help or version was asked for and printed. Throws UsageError.
std::optional<PreviewOptions> parse_preview_options(int argc, const char* const* argv);

}  // namespace stbvh::harness
