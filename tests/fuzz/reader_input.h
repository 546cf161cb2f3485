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

/// Lets TBB run one thread, as long as the program lives: what an input covers must not depend on who runs
/// the tasks.
void use_one_thread();

/// Aborts unless `scene` is one that the rest of the harness can work on.
void check_scene(const harness::Scene& scene);

}  // namespace stbvh::fuzz
