#include "harness/program/make_folder.h"

#include <fmt/format.h>

#include <system_error>

#include "harness/program/usage_error.h"

namespace stbvh::harness {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw UsageError(fmt::format("Cannot make the directory \"{}\": {}.", folder.string(), error.message()));
}

}  // namespace stbvh::harness
