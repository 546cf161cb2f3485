/// The fuzzer's bytes as the files that readers take.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "harness/scenes/scene.h"

namespace stbvh::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A new folder below the system's for temporary files; tests/fuzz/run puts it into memory, and removes it.
class InputFolder {
 public:
  InputFolder();

  /// Writes a file, in place of what was there.
  std::filesystem::path write(const std::string& name, Bytes bytes) const;
  std::filesystem::path write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

/// What a target does with an input; each defines its own.
void run(Bytes bytes);

/// Aborts unless `scene` is one that the rest of the harness can work on.
void check_scene(const harness::Scene& scene);

}  // namespace stbvh::fuzz
