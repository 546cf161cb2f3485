/// Pictures for people, made from the layers of images.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/images/compare.h"
#include "harness/images/layered_image.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// Writes `image`, tone mapped, as `folder`/`name`.png; returns the file's name. Throws OutputFileError.
std::string write_picture(const LayeredImage& image, const std::filesystem::path& folder,
                          const std::string& name);

/// Likewise FLIP at each pixel.
std::string write_difference(const Comparison& found, const std::filesystem::path& folder,
                             const std::string& name);

/// An OpenEXR file that `render` wrote for a scene and structure.
struct RenderFile {
  std::string scene;
  std::string structure;
  std::filesystem::path path;
};

/// Writes the pictures of one scene's renderings into `folder`: each of them, how it differs from that of
/// `stbvh-direct` (the first one without it), what camera rays met. Throws ImageFileError, ComparisonError
/// and OutputFileError.
std::vector<RenderResult> show_renderings(const std::vector<RenderFile>& files,
                                          const std::filesystem::path& folder);

}  // namespace stbvh::harness
