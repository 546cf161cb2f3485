#include "harness/cli/check_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <span>

#include "harness/cli/closest_name.h"
#include "harness/cli/pinned_threads.h"
#include "harness/cli/render_options.h"
#include "harness/cli/report_options.h"
#include "harness/cli/usage_error.h"
#include "harness/hard_cases/hard_case.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/reach.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr double kLargestScale = 4;
constexpr std::size_t kLargestObjStep = 1'000'000;
constexpr std::size_t kMostRepeats = 10'000;
constexpr std::size_t kMostRays = 100'000'000;
constexpr std::size_t kMostTriangles = 100'000'000;
constexpr std::array<std::string_view, 1> kPictureStructure{"stbvh"};
constexpr std::array<std::string_view, 3> kOverNames{"steps", "triangles", "threads"};

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The names, each once, with "paper" and "all" replaced by the scenes they stand for.
std::vector<std::string> named_scenes(const std::vector<std::string>& asked) {
  std::vector<std::string> names;
  const auto add = [&](std::string_view name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  };
  for (const std::string& name : asked) {
    if (name == "paper") {
      for (const ProceduralScene& scene : paper_scenes()) add(scene.name);
    } else if (name == "all") {
      for (const ProceduralScene& scene : procedural_scenes()) add(scene.name);
    } else {
      add(name);
    }
  }
  return names;
}

void check_scale(Arguments& a, const CLI::App& command) {
  if (command.count("--scale") == 0) return;
  if (!(a.scale > 0) || !(a.scale <= kLargestScale)) {
    throw UsageError(fmt::format("--scale must be above 0 and at most {}, not {}.", kLargestScale, a.scale));
  }
  a.options.scale = a.scale;
}

/// A number of steps, or auto:E.
void check_steps(const std::string& steps, GltfOptions& gltf) {
  constexpr std::string_view kAuto = "auto:";
  if (steps.starts_with(kAuto)) {
    const auto share = parse_number(std::string_view(steps).substr(kAuto.size()));
    if (!share || !(*share > 0) || !(*share < 1)) {
      throw UsageError(
          fmt::format("--steps auto:E takes an E between 0 and 1, as in auto:1e-3, not \"{}\".", steps));
    }
    gltf.largest_deviation = *share;
    return;
  }
  const auto count = parse_number(steps);
  if (!count || !(*count >= 1) || !(*count <= double{kMaxSteps}) || *count != std::floor(*count)) {
    throw UsageError(fmt::format("--steps must be 1 to {}, or auto:E, not \"{}\".", kMaxSteps, steps));
  }
  gltf.steps = static_cast<std::size_t>(*count);
}

void check_shutter_mode(const std::string& mode, GltfOptions& gltf) {
  constexpr std::array<std::string_view, 2> kModes{"clamp", "loop"};
  const auto known = std::find(kModes.begin(), kModes.end(), mode);
  if (known == kModes.end()) throw UsageError(unknown_name("shutter mode", mode, kModes));
  gltf.shutter_mode = known == kModes.begin() ? ShutterMode::kClamp : ShutterMode::kLoop;
}

void check_range(const char* option, std::size_t value, std::size_t most) {
  if (value < 1 || value > most)
    throw UsageError(fmt::format("{} must be 1 to {}, not {}.", option, most, value));
}

/// Those of `known` that are in `asked`, in their order; all where it is empty or says "all".
std::vector<std::string> chosen_names(std::string_view what, const std::vector<std::string>& asked,
                                      std::span<const std::string_view> known) {
  const auto is_asked = [&](std::string_view name) {
    return std::find(asked.begin(), asked.end(), name) != asked.end();
  };
  for (const std::string& name : asked) {
    if (name != "all" && std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError(unknown_name(what, name, known));
  }
  std::vector<std::string> chosen;
  for (std::string_view name : known) {
    if (asked.empty() || is_asked("all") || is_asked(name)) chosen.emplace_back(name);
  }
  return chosen;
}

}  // namespace

void check_scene_options(Arguments& a, const CLI::App& command) {
  Options& o = a.options;
  for (const CLI::Option* option : a.scene_options) {
    if (option->count() > 0)
      o.scene_words.insert(o.scene_words.end(),
                           {option->get_name(), fmt::format("{}", fmt::join(option->results(), ","))});
  }
  o.scenes = named_scenes(o.scenes);
  check_scale(a, command);
  if (command.count("--shutter") > 0) {
    const auto [begin, end] = parse_pair(a.shutter, ',', "--shutter");
    if (!(begin >= 0) || !(begin < end) || !std::isfinite(end)) {
      throw UsageError(fmt::format("--shutter must be A,B with 0 <= A < B, not \"{}\".", a.shutter));
    }
    o.gltf.shutter_seconds = TimeRange{static_cast<float>(begin), static_cast<float>(end)};
  }
  check_shutter_mode(a.shutter_mode, o.gltf);
  check_steps(a.steps, o.gltf);
  check_range("--step", o.obj_step, kLargestObjStep);
}

void check_structures(Options& o, std::span<const std::string_view> otherwise) {
  if (o.structures.empty()) o.structures.assign(otherwise.begin(), otherwise.end());
  o.structures = chosen_names("structure", o.structures, structure_names());
}

void check_threads(Options& o) {
  std::vector<unsigned>& counts = o.thread_counts;
  if (counts.empty()) counts = {o.threads};
  for (unsigned count : counts) check_range("--threads", count, usable_core_count());
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  o.threads = counts.back();
}

namespace {

void check_families(Options& o) {
  std::vector<std::string_view> known;
  for (const HardFamily& family : hard_families()) known.push_back(family.name);
  o.families = chosen_names("family", o.families, known);
}

void check_rays(Arguments& a) {
  std::vector<std::string_view> known;
  for (RayKind kind : ray_kinds()) known.push_back(ray_kind_name(kind));
  for (const std::string& name : a.rays) {
    if (!find_ray_kind(name)) throw UsageError(unknown_name("kind of rays", name, known));
  }
  for (RayKind kind : ray_kinds()) {
    if (std::find(a.rays.begin(), a.rays.end(), ray_kind_name(kind)) != a.rays.end()) {
      a.options.rays.push_back(kind);
    }
  }
}

/// What commands have that trace rays; `rays` of them where --count does not say.
void check_trace(Arguments& a, const CLI::App& command, std::size_t rays,
                 std::span<const std::string_view> structures = {}) {
  Options& o = a.options;
  check_structures(o, structures);
  check_rays(a);
  check_threads(o);
  if (command.count("--count") == 0) o.count = rays;
  check_range("--count", o.count, kMostRays);
  check_range("--repeats", o.repeats, kMostRepeats);
  if (!(o.build_budget_s >= 0) || !std::isfinite(o.build_budget_s))
    throw UsageError(fmt::format("--build-budget must be at least 0 seconds, not {}.", o.build_budget_s));
  if (!a.json.empty()) o.json = a.json;
  if (!a.tables.empty()) o.tables = a.tables;
}

void check_bench(Arguments& a, const CLI::App& command) {
  check_trace(a, command, kDefaultBenchRays);
}

void check_error(Arguments& a, const CLI::App& command) {
  check_trace(a, command, kDefaultErrorRays);
}

void check_hard(Arguments& a, const CLI::App& command) {
  check_families(a.options);
  check_trace(a, command, kDefaultHardRays, kHardStructures);
}

void check_pareto(Arguments& a, const CLI::App& command) {
  if (command.count("--plot") > 0) {
    if (a.json.empty()) throw UsageError("--plot needs --json: the plot is made from the records.");
    a.options.plot = a.plot;
  }
  const bool is_measured = a.options.record_files.empty();
  check_trace(a, command, kDefaultParetoRays,
              is_measured ? std::span<const std::string_view>(kParetoStructures)
                          : std::span<const std::string_view>());
}

/// What is measured where --values does not say.
std::vector<std::size_t> default_values(Over over) {
  switch (over) {
    case Over::kSteps:
      return {2, 3, 5, 9, 17, 33, 65, 129};
    case Over::kTriangles:
      return {100'000, 200'000, 500'000, 1'000'000};
    case Over::kThreads:
      break;
  }
  std::vector<std::size_t> counts;
  for (std::size_t count = 1; count <= usable_core_count(); ++count) counts.push_back(count);
  return counts;
}

void check_values(Options& o) {
  if (o.values.empty()) o.values = default_values(o.over);
  std::sort(o.values.begin(), o.values.end());
  o.values.erase(std::unique(o.values.begin(), o.values.end()), o.values.end());
  if (o.over == Over::kSteps && o.values.front() < 2) throw UsageError("--values: at least 2 steps.");
  const std::size_t most = o.over == Over::kSteps     ? kMaxSteps
                           : o.over == Over::kThreads ? usable_core_count()
                                                      : kMostTriangles;
  check_range("--values", o.values.front(), most);
  check_range("--values", o.values.back(), most);
}

void check_scaling(Arguments& a, const CLI::App& command) {
  Options& o = a.options;
  const auto over = std::find(kOverNames.begin(), kOverNames.end(), a.over);
  if (over == kOverNames.end()) throw UsageError(unknown_name("thing to vary", a.over, kOverNames));
  o.over = static_cast<Over>(over - kOverNames.begin());
  std::vector<std::string_view> known;
  for (const ProceduralScene& scene : procedural_scenes()) {
    if (scene.make_with_steps != nullptr) known.push_back(scene.name);
  }
  if (std::find(known.begin(), known.end(), a.scene) == known.end()) {
    throw UsageError(unknown_name("scene of any number of steps", a.scene, known));
  }
  o.scenes = {a.scene};
  check_values(o);
  if (o.over == Over::kTriangles && command.count("--scale") > 0)
    throw UsageError("--scale: with --over triangles, --values says how many.");
  if (o.over == Over::kThreads && command.count("--threads") > 0)
    throw UsageError("--threads: with --over threads, --values says how many.");
  if (command.count("--build-budget") == 0) o.build_budget_s = kScalingBuildBudget;
  a.rays = {"bounce", "uniform"};
  if (o.over == Over::kTriangles) a.rays.clear();
  check_scale(a, command);
  check_trace(a, command, kDefaultScalingRays);
}

void check_charts(Arguments& a, const CLI::App&) {
  a.options.directory = a.directory;
}

void check_results(Arguments& a, const CLI::App&) {
  a.options.output = a.output;
}

void check_compare(Arguments& a, const CLI::App&) {
  if (!a.difference_png.empty()) a.options.difference_png = a.difference_png;
  if (!a.json.empty()) a.options.json = a.json;
}

void check_render(Arguments& a, const CLI::App& command) {
  check_structures(a.options, kPictureStructure);
  check_threads(a.options);
  check_render_options(a, command);
}

void check_report(Arguments& a, const CLI::App&) {
  check_report_options(a);
  if (!a.options.structures.empty()) check_structures(a.options);
  check_threads(a.options);
}

void check_truth(Arguments& a, const CLI::App& command) {
  Options& o = a.options;
  check_truth_options(a, command);
  check_structures(o, kPictureStructure);
  if (o.structures.size() != 1) throw UsageError("--structures: one structure.");
  check_threads(o);
  if (!a.json.empty()) o.json = a.json;
  o.render.seed = o.seed;
  o.render.threads = o.threads;
}

void check_convert(Arguments& a, const CLI::App&) {
  Options& o = a.options;
  if (o.scenes.size() != 1) throw UsageError("convert takes one scene at a time.");
  o.converted = a.converted;
  if (o.converted.extension() != ".xml")
    throw UsageError(fmt::format("convert writes .xml files, not \"{}\".", a.converted));
}

struct CommandChecks {
  std::string_view name;
  Command command;
  bool has_scenes;
  void (*check)(Arguments&, const CLI::App&);
};
constexpr CommandChecks kCommands[] = {
    {"list", Command::kList, false, [](Arguments&, const CLI::App&) {}},
    {"bench", Command::kBench, true, check_bench},
    {"error", Command::kError, true, check_error},
    {"hard", Command::kHard, false, check_hard},
    {"pareto", Command::kPareto, true, check_pareto},
    {"scaling", Command::kScaling, false, check_scaling},
    {"charts", Command::kCharts, false, check_charts},
    {"results", Command::kResults, false, check_results},
    {"render", Command::kRender, true, check_render},
    {"compare", Command::kCompare, false, check_compare},
    {"truth", Command::kTruth, true, check_truth},
    {"report", Command::kReport, true, check_report},
    {"convert", Command::kConvert, true, check_convert},
};

}  // namespace

std::pair<double, double> parse_pair(std::string_view text, char separator, std::string_view option) {
  const std::size_t at = std::min(text.find(separator), text.size());
  const auto first = parse_number(text.substr(0, at));
  const auto second = parse_number(text.substr(std::min(at + 1, text.size())));
  if (!first || !second) {
    throw UsageError(
        fmt::format("{} takes two numbers with \"{}\" between, not \"{}\".", option, separator, text));
  }
  return {*first, *second};
}

Vec3f parse_point(std::string_view text, std::string_view option) {
  std::array<float, 3> numbers{};
  std::string_view rest = text;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t end = i < 2 ? std::min(rest.find(','), rest.size()) : rest.size();
    const auto number = parse_number(rest.substr(0, end));
    if (!number) {
      throw UsageError(fmt::format("{} takes three numbers with \",\" between, not \"{}\".", option, text));
    }
    if (!is_within_reach(*number)) {
      throw UsageError(
          fmt::format("{}: coordinates must be below {}, not \"{}\".", option, kMaxCoordinate, text));
    }
    numbers[i] = static_cast<float>(*number);
    rest = rest.substr(std::min(end + 1, rest.size()));
  }
  return {numbers[0], numbers[1], numbers[2]};
}

std::string_view over_name(Over over) {
  return kOverNames[static_cast<std::size_t>(over)];
}

Options checked_options(Arguments a, const CLI::App& command) {
  const auto& checks = *std::find_if(std::begin(kCommands), std::end(kCommands),
                                     [&](const CommandChecks& c) { return c.name == command.get_name(); });
  a.options.command = checks.command;
  if (checks.has_scenes) check_scene_options(a, command);
  checks.check(a, command);
  return a.options;
}

}  // namespace stbvh::harness
