/// USD and Alembic files of tests, read through the libraries: skipped where their Python cannot be made.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "harness/program/shot_reader.h"
#include "harness/scenes/shots/shot.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {

inline const std::string kSource = STBVH_SOURCE_DIR;
inline const std::string kScripts = kSource + "/harness/scenes/shots";

inline std::string in_quotes(const fs::path& path) {
  return fmt::format("'{}'", path.string());
}

/// Interpreter of the shots, made if need be; empty where that cannot be.
inline std::string shots_python() {
  const Outcome run = run_command(
      fmt::format("/usr/bin/python3 -B -c 'import sys; sys.path.insert(0, \"{}\"); import shot_environment; "
                  "print(shot_environment.ensure())' 2>/dev/null",
                  kScripts));
  return run.exit_code == 0 ? run.out.substr(0, run.out.find('\n')) : "";
}

class ShotsTest : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    if (python_.empty()) GTEST_SKIP() << "the Python environment that reads shots cannot be made";
  }

  static fs::path data(const std::string& name) { return fs::path(kSource) / "data" / name; }

  /// Writes down what the library is told in Python, for files that are not text.
  void run_python(const std::string& script) const {
    const Outcome run =
        run_command(in_quotes(python_) + " -B " + in_quotes(write("script.py", script)) + " 2>&1");
    ASSERT_EQ(run.exit_code, 0) << run.out;
  }

  Scene load(const fs::path& file, const ShotOptions& options = {}) {
    return read_shot(file.string(), options, [this](const std::string& line) { warnings.push_back(line); });
  }

  bool is_warned_of(const std::string& words) const {
    return std::ranges::any_of(
        warnings, [&](const std::string& line) { return line.find(words) != std::string::npos; });
  }

  std::vector<std::string> warnings;
  const std::string python_ = shots_python();
};

inline const Mesh* find_mesh(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.meshes, name, &Mesh::name);
  return found == scene.meshes.end() ? nullptr : &*found;
}

/// Of the files that others made: next to the repository, as it stands in the sources' folder or in a
/// worktree of it.
inline fs::path shared_shots() {
  for (const char* folder : {"/../shared/assets/shots", "/../../shared/assets/shots"}) {
    if (fs::exists(kSource + folder)) return kSource + folder;
  }
  return {};
}

inline std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (is_shot_name(entry.path().string())) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace stbvh::harness
