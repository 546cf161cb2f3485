#include "harness/cli/picture_files.h"

#include <fmt/format.h>

#include "harness/program/usage_error.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {

namespace fs = std::filesystem;

fs::path png_beside(fs::path file) {
  return file.replace_extension(".png");
}

void check_picture_file(const fs::path& file, bool with_png) {
  if (png_beside(file) == file)
    throw UsageError(fmt::format(
        "\"{}\" is to be an OpenEXR file: it cannot end in .png. With --png there is a PNG beside it.",
        file.string()));
  check_writable(file);
  if (with_png) check_writable(png_beside(file));
}

}  // namespace stbvh::harness
