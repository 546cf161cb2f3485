/// What a user would do, line by line in a file: for tests, and for the pictures in docs/preview.md.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "harness/preview/preview_model.h"

namespace stbvh::harness {

struct ScriptCommand {
  std::size_t line = 0;  ///< in the file, from 1
  std::string name;
  std::vector<std::string> words;  ///< behind the name, as many as the command takes

  double number(std::size_t i) const;  ///< words[i], which is one
};

/// Commands one to a line; empty lines and what follows a # that begins a word say nothing. Throws
/// UsageError, which names the line, for a command that there is not, or words that it does not take.
std::vector<ScriptCommand> parse_script(const std::string& text);

/// parse_script() of a file. Throws UsageError where it cannot be read.
std::vector<ScriptCommand> read_script(const std::filesystem::path& file);

/// What commands need of the window.
class ScriptStage {
 public:
  virtual ~ScriptStage() = default;
  virtual void resize(int width, int height) = 0;
  virtual void show_panels(bool shown) = 0;
  virtual void take_screenshot(const std::filesystem::path& file) = 0;  ///< of the frame that comes next
  virtual void close() = 0;
};

/// Runs a script, one command before each frame, so that each finds what the last one did.
class ScriptRunner {
 public:
  ScriptRunner(std::vector<ScriptCommand> commands, PreviewModel& model, ScriptStage& stage)
      : commands_(std::move(commands)), model_(model), stage_(stage) {}

  /// Carries out the next command; or goes on waiting, `elapsed` seconds after the last call. Throws
  /// UsageError for what cannot be done.
  void step(double elapsed);
  bool is_done() const { return next_ == commands_.size(); }

 private:
  bool carry_out(const ScriptCommand& command, double elapsed);
  bool carry_out_view(const ScriptCommand& command);
  bool carry_out_time(const ScriptCommand& command);
  bool carry_out_tree(const ScriptCommand& command);

  std::vector<ScriptCommand> commands_;
  PreviewModel& model_;
  ScriptStage& stage_;
  std::size_t next_ = 0;
  double waited_ = 0;
};

}  // namespace stbvh::harness
