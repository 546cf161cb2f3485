#include "harness/program/scene_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "harness/program/options.h"
#include "harness/program/program.h"
#include "harness/program/usage_error.h"
#include "harness/program/whole_numbers.h"
#include "harness/scenes/procedural/procedural.h"

namespace stbvh::harness {
namespace {

constexpr double kLargestScale = 4;
constexpr std::size_t kLargestObjStep = 1'000'000;
constexpr double kMostBytes = 1e18;

double checked_scale(double scale) {
  if (scale > 0 && scale <= kLargestScale) return scale;
  throw UsageError(fmt::format("--scale must be above 0 and at most {}, not {}.", kLargestScale, scale));
}

/// A number of steps, or uneven:N.
void set_resampling(const std::string& text, Resampling& resampling) {
  constexpr std::string_view kUneven = "uneven:";
  const bool is_uneven = text.starts_with(kUneven);
  const auto steps = parse_number(std::string_view(text).substr(is_uneven ? kUneven.size() : 0));
  if (!steps || !(*steps >= 2) || !(*steps <= double{kMaxSteps}) || *steps != std::floor(*steps)) {
    throw UsageError(
        fmt::format("--resample-steps must be 2 to {}, or uneven:N, not \"{}\".", kMaxSteps, text));
  }
  resampling.steps = static_cast<std::size_t>(*steps);
  resampling.places = is_uneven ? StepPlaces::kUneven : StepPlaces::kEquidistant;
}

double checked_tolerance(double share) {
  if (share >= 0 && share < 1) return share;
  throw UsageError(fmt::format("--tolerance must be at least 0 and below 1, not {}.", share));
}

MemoryBudget memory_budget(std::string_view text) {
  const bool is_share = text.ends_with('%');
  const auto value = parse_number(is_share ? text.substr(0, text.size() - 1) : text);
  if (!value || !(*value > 0) || !(*value <= kMostBytes)) {
    throw UsageError(fmt::format(
        "--max-bytes takes a number of bytes, or a share of embree's, as in 40%, not \"{}\".", text));
  }
  if (is_share) return {.bytes = {}, .share = *value / 100};
  return {.bytes = static_cast<std::size_t>(*value), .share = {}};
}

FilePart shutter_of(const std::string& text) {
  const auto [begin, end] = parse_pair(text, ',', "--shutter");
  if (!(begin <= end) || !std::isfinite(begin) || !std::isfinite(end))
    throw UsageError(fmt::format("--shutter must be A,B with A <= B, not \"{}\".", text));
  return {.begin = begin, .end = end};
}

ShutterMode shutter_mode(const std::string& name) {
  constexpr std::array<std::string_view, 2> kModes{"clamp", "loop"};
  return index_of("shutter mode", name, kModes) == 0 ? ShutterMode::kClamp : ShutterMode::kLoop;
}

/// A number of steps, auto:E, keys, or keys:E.
void set_steps(const std::string& steps, GltfOptions& gltf) {
  gltf.at_keys = steps.starts_with("keys");
  gltf.largest_deviation.reset();
  if (steps == "keys") return;
  if (steps.starts_with("auto:") || steps.starts_with("keys:")) {
    const auto share = parse_number(std::string_view(steps).substr(5));
    if (!share || !(*share > 0) || !(*share < 1)) {
      throw UsageError(fmt::format("--steps {0}:E takes an E between 0 and 1, as in {0}:1e-3, not \"{1}\".",
                                   steps.substr(0, 4), steps));
    }
    gltf.largest_deviation = *share;
    return;
  }
  const auto count = parse_number(steps);
  if (!count || !(*count >= 1) || !(*count <= double{kMaxSceneSteps}) || *count != std::floor(*count)) {
    throw UsageError(
        fmt::format("--steps must be 1 to {}, auto:E, keys or keys:E, not \"{}\".", kMaxSceneSteps, steps));
  }
  gltf.steps = static_cast<std::size_t>(*count);
}

/// Keeps what is given of the options that `app` has from the index `first` on.
void keep_words(CLI::App& app, std::size_t first, std::vector<std::string>& words) {
  app.parse_complete_callback([&, first, count = app.get_options().size()] {
    const std::vector<CLI::Option*> options = app.get_options();
    words.clear();
    for (std::size_t i = first; i < count; ++i) {
      if (options[i]->count() == 0) continue;
      words.insert(words.end(),
                   {options[i]->get_name(), fmt::format("{}", fmt::join(options[i]->results(), ","))});
    }
  });
}

}  // namespace

void print_warning(const std::string& sentence) {
  const bool is_terminal = isatty(STDERR_FILENO) != 0;  // where a line of Progress may stand
  write_to_stderr(fmt::format("{}stbvh-ab: {}\n", is_terminal ? "\r\x1b[K" : "", one_line(sentence)));
}

std::vector<std::string> named_scenes(const std::vector<std::string>& asked) {
  std::vector<std::string> names;
  const auto add = [&](std::string_view name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  };
  for (const std::string& name : asked) {
    const std::span<const ProceduralScene> group = scene_group(name);
    for (const ProceduralScene& scene : group) add(scene.name);
    if (group.empty()) add(name);
  }
  return names;
}

void add_scale_option(CLI::App& app, std::optional<double>& scale) {
  app.add_option_function<double>(
      "--scale", [&scale](double value) { scale = checked_scale(value); },
      "Size of the built-in scenes; 1 has as many triangles as the paper's. Default: each scene's own "
      "(see list)");
}

void add_resampling_option(CLI::App& app, Resampling& resampling) {
  app.add_option_function<std::string>(
      "--resample-steps", [&resampling](const auto& steps) { set_resampling(steps, resampling); },
      "Hand every mesh over with so many steps, 2 to 4096, also what stands still; or uneven:N, N steps at "
      "times of their own. Default: as they are");
}

void add_tolerance_option(CLI::App& app, double& tolerance) {
  app.add_option_function<double>(
      "--tolerance", [&tolerance](double share) { tolerance = checked_tolerance(share); },
      "How far structures that can may be from the motion, of the scene's diagonal: they leave out steps. "
      "Default: 0, within rounding");
}

void add_max_bytes_option(CLI::App& app, MemoryBudget& budget) {
  app.add_option_function<std::string>(
      "--max-bytes", [&budget](const std::string& text) { budget = memory_budget(text); },
      "Bytes that structures that can may take, or a share of what embree takes, as in 40%. Default: no "
      "limit");
}

void add_making_options(CLI::App& app, MakingOptions& m) {
  const std::size_t first = app.get_options().size();
  add_scale_option(app, m.scale);
  add_seed_option(app, m.seed, "Seed of scenes and rays");
  app.add_option("--clip", m.gltf.clip, "glTF: name or number of the animation. Default: the first");
  app.add_option("--gltf-scene", m.gltf.scene,
                 "glTF: name or number of the scene. Default: the file's own, or the first with a mesh");
  app.add_option_function<std::string>(
      "--shutter", [&m](const auto& text) { m.gltf.shutter = shutter_of(text); },
      "glTF, USD, Alembic: A,B, the part of the clip in seconds. Default: all of it");
  app.add_option_function<std::string>(
         "--shutter-mode", [&m](const auto& name) { m.gltf.shutter_mode = shutter_mode(name); },
         "glTF: where the shutter is longer than the clip: clamp (its ends are held) or loop (it is "
         "played again)")
      ->default_str("clamp");
  app.add_option_function<std::string>(
         "--steps", [&m](const auto& steps) { set_steps(steps, m.gltf); },
         "glTF: steps of each moving mesh; auto:E, for each mesh as few as keep it within E times "
         "the diagonal of its true motion, as in auto:1e-3; or keys, those of the file, with more between "
         "them where motion is curved: within 1e-5 of the diagonal, or within E with keys:E. USD and Alembic "
         "are read with keys:1e-6, or keys:E")
      ->default_str(std::to_string(m.gltf.steps));
  add_number_option(
      app, "--step", m.obj_step, kLargestObjStep,
      "OBJ: by how much the numbers of a sequence go up from file to file, as in 2 for one on twos");
  add_resampling_option(app, m.resampling);
  add_tolerance_option(app, m.tolerance);
  add_max_bytes_option(app, m.max_bytes);
  keep_words(app, first, m.scene_words);
}

void add_scene_options(CLI::App& app, SceneOptions& s) {
  const std::size_t first = app.get_options().size();
  app.add_option_function<std::vector<std::string>>(
         "--scenes", [&s](const auto& asked) { s.scenes = named_scenes(asked); },
         "Names of built-in scenes (see list), paper (its six), large (ten), small (three), all, .glb, "
         ".gltf, .usd, .usda, .usdc, .usdz, "
         ".abc, .xml (Embree's), .ecs and .stbvh files, or .obj files (one for each step: walk_%04d.obj, or "
         "a folder); separated by commas")
      ->delimiter(',')
      ->default_str("[paper]");
  add_making_options(app, s);
  keep_words(app, first, s.scene_words);
}

std::string shell_word(const std::string& word) {
  const bool is_plain =
      !word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%") ==
          std::string::npos;
  if (is_plain) return word;
  std::string quoted = "'";
  for (char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace stbvh::harness
