#include "harness/preview/preview_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "harness/files/input_file.h"
#include "harness/files/text.h"
#include "harness/program/closest_name.h"
#include "harness/program/usage_error.h"
#include "harness/scenes/reach.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

/// A command and what it takes: n a number, w a word.
struct CommandShape {
  std::string_view name;
  std::string_view words;
};

constexpr std::array<CommandShape, 30> kCommands{{
    {"open", "w"},     {"drop", "w"},     {"structure", "ww"}, {"view", "w"},    {"split", "n"},
    {"gain", "n"},     {"heatmap", "w"},  {"largest", "n"},    {"orbit", "nn"},  {"pan", "nn"},
    {"dolly", "n"},    {"focus", "nn"},   {"pick", "nn"},      {"fov", "n"},     {"lens", "n"},
    {"scrub", "n"},    {"shutter", "w"},  {"frames", "n"},     {"play", "w"},    {"tree", "w"},
    {"timeline", "w"}, {"subtree", "nn"}, {"panels", "w"},     {"resize", "nn"}, {"wait", "n"},
    {"sleep", "n"},    {"cancel", ""},    {"save", "w"},       {"command", "w"}, {"screenshot", "w"},
}};
constexpr CommandShape kClose{"close", ""};

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

const CommandShape* find_command(std::string_view name) {
  if (name == kClose.name) return &kClose;
  const auto found = std::find_if(kCommands.begin(), kCommands.end(),
                                  [&](const CommandShape& shape) { return shape.name == name; });
  return found == kCommands.end() ? nullptr : &*found;
}

[[noreturn]] void refuse(const ScriptCommand& command, const std::string& why) {
  throw UsageError(fmt::format("Line {} of the script: {}", command.line, why));
}

void check(const ScriptCommand& command) {
  const CommandShape* shape = find_command(command.name);
  if (shape == nullptr) {
    std::vector<std::string_view> names{kClose.name};
    for (const CommandShape& s : kCommands) names.push_back(s.name);
    refuse(command, unknown_name("command", command.name, names));
  }
  if (command.words.size() != shape->words.size()) {
    refuse(command, fmt::format("\"{}\" takes {} words behind it, not {}.", command.name, shape->words.size(),
                                command.words.size()));
  }
  for (std::size_t i = 0; i < command.words.size(); ++i) {
    if (shape->words[i] == 'n' && !parse_number(command.words[i]))
      refuse(command, fmt::format("\"{}\" is not a number.", command.words[i]));
  }
}

/// The place of a word among names.
template <typename Enum, std::size_t kCount>
Enum choose(const ScriptCommand& command, std::string_view what,
            const std::array<std::string_view, kCount>& names) {
  const auto found = std::find(names.begin(), names.end(), command.words[0]);
  if (found == names.end()) refuse(command, unknown_name(what, command.words[0], names));
  return static_cast<Enum>(found - names.begin());
}

bool is_on(const ScriptCommand& command) {
  constexpr std::array<std::string_view, 2> kSwitch{"off", "on"};
  return choose<int>(command, "position of a switch", kSwitch) == 1;
}

/// A whole number from 0 up to `most`.
std::size_t whole(const ScriptCommand& command, std::size_t i, double most) {
  const auto number = parse_number(command.words[i]);
  if (!number || !(*number >= 0 && *number <= most) || *number != std::floor(*number))
    refuse(command, fmt::format("\"{}\" takes a whole number from 0 to {}, not \"{}\".", command.name, most,
                                command.words[i]));
  return static_cast<std::size_t>(*number);
}

}  // namespace

double ScriptCommand::number(std::size_t i) const {
  return parse_number(words[i]).value();
}

std::vector<ScriptCommand> parse_script(const std::string& text) {
  std::vector<ScriptCommand> commands;
  std::string_view rest = text;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    std::string_view line = take_line(rest);
    line = without_comment(line);
    ScriptCommand command{number, std::string(take_word(line)), {}};
    if (command.name.empty()) continue;
    for (auto word = take_word(line); !word.empty(); word = take_word(line)) command.words.emplace_back(word);
    check(command);
    commands.push_back(std::move(command));
  }
  return commands;
}

std::vector<ScriptCommand> read_script(const std::filesystem::path& file) {
  try {
    return parse_script(read_text_file(file, kMaxHandwrittenBytes));
  } catch (const InputFileError& error) {
    throw UsageError(fmt::format("The script \"{}\" {}.", file.string(), error.what()));
  }
}

void ScriptRunner::step(double elapsed) {
  if (is_done()) return;
  const ScriptCommand& command = commands_[next_];
  bool is_carried_out = false;
  try {
    is_carried_out = carry_out(command, elapsed);
  } catch (const UsageError& e) {
    const std::string text = e.what();
    if (text.starts_with("Line ")) throw;
    refuse(command, text);
  }
  if (!is_carried_out) return;
  waited_ = 0;
  ++next_;
}

/// False: not yet.
bool ScriptRunner::carry_out(const ScriptCommand& c, double elapsed) {
  if (c.name == "wait") return model_.has_samples(whole(c, 0, 65536));
  if (c.name == "sleep") return (waited_ += elapsed) >= c.number(0);
  if (c.name == "open" || c.name == "drop") {
    model_.open(c.words[0]);
  } else if (c.name == "cancel") {
    model_.cancel();
  } else if (c.name == "resize") {
    stage_.resize(static_cast<int>(whole(c, 0, 16384)), static_cast<int>(whole(c, 1, 16384)));
  } else if (c.name == "panels") {
    stage_.show_panels(is_on(c));
  } else if (c.name == "screenshot") {
    stage_.take_screenshot(c.words[0]);
  } else if (c.name == "save") {
    model_.save(c.words[0]);
  } else if (c.name == "command") {
    write_file(c.words[0], model_.command_line() + "\n");
  } else if (c.name == "close") {
    stage_.close();
  } else {
    return carry_out_view(c) || carry_out_time(c) || carry_out_tree(c);
  }
  return true;
}

/// False: it is another kind of command; so below.
bool ScriptRunner::carry_out_view(const ScriptCommand& c) {
  ViewOptions& view = model_.view_options;
  if (c.name == "structure") {
    if (c.words[0] != "a" && c.words[0] != "b") refuse(c, "a structure is a or b.");
    model_.choose_structure(c.words[0] == "a" ? 0 : 1, c.words[1] == "none" ? "" : c.words[1]);
  } else if (c.name == "view") {
    view.mode = choose<ViewMode>(c, "view", kViewModeNames);
  } else if (c.name == "split") {
    view.split = c.number(0);
  } else if (c.name == "gain") {
    view.gain = c.number(0);
  } else if (c.name == "heatmap") {
    view.heat = choose<HeatMap>(c, "heat map", kHeatMapNames);
  } else if (c.name == "largest") {
    view.heat_largest = std::max(1.0, c.number(0));
  } else if (c.name == "orbit") {
    model_.camera.orbit(c.number(0), c.number(1));
  } else if (c.name == "pan") {
    model_.camera.pan(c.number(0), c.number(1));
  } else if (c.name == "dolly") {
    if (!(c.number(0) > 0)) refuse(c, "the distance is multiplied with a number above 0.");
    model_.camera.dolly(c.number(0));
  } else if (c.name == "focus") {
    if (!model_.focus(c.number(0), c.number(1))) refuse(c, "there is nothing to focus on.");
  } else if (c.name == "fov") {
    model_.camera.set_fov(c.number(0));
  } else if (c.name == "lens") {
    if (!is_within_reach(c.number(0))) refuse(c, "a lens is not that large.");
    model_.lens_radius = std::max(0.0, c.number(0));
  } else {
    return false;
  }
  return true;
}

bool ScriptRunner::carry_out_time(const ScriptCommand& c) {
  Animation& animation = model_.animation;
  if (c.name == "scrub") {
    animation.scrub(c.number(0));
  } else if (c.name == "shutter") {
    constexpr std::array<std::string_view, 3> kShutters{"whole", "frozen", "frame"};
    const auto chosen = choose<int>(c, "shutter", kShutters);
    animation.is_whole = chosen == 0;
    animation.is_frozen = chosen == 1;
  } else if (c.name == "frames") {
    animation.frames = std::max<std::size_t>(1, whole(c, 0, 10000));
  } else if (c.name == "play") {
    animation.is_playing = is_on(c);
  } else {
    return false;
  }
  return true;
}

bool ScriptRunner::carry_out_tree(const ScriptCommand& c) {
  TreeOptions& tree = model_.tree_options;
  if (c.name == "tree") {
    tree.shows_boxes = c.words[0] != "off";
    if (tree.shows_boxes) tree.level = whole(c, 0, 90);
  } else if (c.name == "timeline") {
    constexpr std::array<std::string_view, 4> kAxes{"x", "y", "z", "off"};
    const auto chosen = choose<std::size_t>(c, "axis", kAxes);
    tree.shows_time_line = chosen < 3;
    if (tree.shows_time_line) tree.axis = chosen;
  } else if (c.name == "subtree") {
    tree.subtree_level = whole(c, 0, 90);
    tree.depth = whole(c, 1, 90);
  } else if (c.name == "pick") {
    if (!model_.pick_subtree(c.number(0), c.number(1))) refuse(c, "there is nothing to pick.");
  } else {
    return false;
  }
  return true;
}

}  // namespace stbvh::harness
