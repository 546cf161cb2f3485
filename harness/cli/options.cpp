#include "harness/cli/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>

#include "harness/cli/closest_name.h"
#include "harness/cli/pinned_threads.h"
#include "harness/cli/usage_error.h"
#include "harness/picture/render_picture.h"
#include "harness/rays/ray_generator.h"
#include "harness/report/machine.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"
#include "tests/hard_cases/hard_case.h"

namespace stbvh::harness {
namespace {

constexpr double kLargestScale = 4;
constexpr std::size_t kMostRepeats = 10'000;
/// What `hard` compares where it is not told: ours in every layout and instruction set, Embree's in every
/// precision.
constexpr std::array<std::string_view, 7> kHardStructures{
    "stbvh-direct", "stbvh-direct-indexed", "stbvh-direct-scalar", "stbvh", "embree", "embree-robust",
    "embree-4v"};
/// What `pareto` compares: each structure in each precision.
constexpr std::array<std::string_view, 9> kParetoStructures{
    "embree",     "embree-robust", "embree-4v",        "lbvh", "lbvh-4v", "stbvh",
    "stbvh-fast", "stbvh-direct",  "stbvh-direct-fast"};
constexpr std::size_t kMostRays = 100'000'000;

/// What the command line holds, before it is checked.
struct Arguments {
  Options options;
  std::vector<std::string> rays{"primary", "bounce", "uniform", "shadow"};
  double scale = 0;
  std::string shutter;
  std::string size;
  std::string json;
  std::string plot;
  std::string directory;
};

void add_scene_options(CLI::App& app, Arguments& a) {
  app.add_option(
         "--scenes", a.options.scenes,
         "Names of built-in scenes (see list), paper (its six), all, or .glb and .gltf files; separated "
         "by commas")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option(
      "--scale", a.scale,
      "Size of the built-in scenes; 1 has as many triangles as the paper's. Default: each scene's own "
      "(see list)");
  app.add_option("--seed", a.options.seed, "Seed of scenes and rays")->capture_default_str();
  app.add_option("--clip", a.options.gltf.clip, "glTF: name or number of the animation. Default: the first");
  app.add_option("--shutter", a.shutter, "glTF: A,B, the part of the clip in seconds. Default: all of it");
  app.add_option("--steps", a.options.gltf.steps, "glTF: steps of each moving mesh")->capture_default_str();
}

void add_common_options(CLI::App& app, Arguments& a, const std::string& default_structures) {
  app.add_option("--structures", a.options.structures,
                 "Names of structures (see list), or all; separated by commas")
      ->delimiter(',')
      ->default_str(default_structures);
  app.add_option("--json", a.json, "File for the records");
}

void add_threads_option(CLI::App& app, Arguments& a) {
  app.add_option("--threads", a.options.threads, "Threads, each pinned to a core; also of the builds")
      ->default_str("all cores");
}

void add_trace_options(CLI::App& app, Arguments& a, std::size_t default_count) {
  add_common_options(app, a, "all");
  app.add_option("--rays", a.rays, "primary, bounce, uniform, shadow, bounce-occluded, uniform-occluded")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--count", a.options.count, "Rays of each kind")->default_str(std::to_string(default_count));
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

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

void check_scenes(Arguments& a, const CLI::App& command) {
  Options& o = a.options;
  o.scenes = named_scenes(o.scenes);
  if (command.count("--scale") > 0) {
    if (!(a.scale > 0) || !(a.scale <= kLargestScale)) {
      throw UsageError(
          fmt::format("--scale must be above 0 and at most {}, not {}.", kLargestScale, a.scale));
    }
    o.scale = a.scale;
  }
  if (command.count("--shutter") > 0) {
    const auto [begin, end] = parse_pair(a.shutter, ',', "--shutter");
    if (!(begin >= 0) || !(begin < end) || !std::isfinite(end)) {
      throw UsageError(fmt::format("--shutter must be A,B with 0 <= A < B, not \"{}\".", a.shutter));
    }
    o.gltf.shutter_seconds = TimeRange{static_cast<float>(begin), static_cast<float>(end)};
  }
  if (o.gltf.steps < 1 || o.gltf.steps > kMaxSteps) {
    throw UsageError(fmt::format("--steps must be 1 to {}, not {}.", kMaxSteps, o.gltf.steps));
  }
}

void check_structures(Options& o) {
  const std::vector<std::string_view> known = structure_names();
  std::vector<std::string> chosen;
  const auto is_asked = [&](std::string_view name) {
    return std::find(o.structures.begin(), o.structures.end(), name) != o.structures.end();
  };
  for (const std::string& name : o.structures) {
    if (name != "all" && std::find(known.begin(), known.end(), name) == known.end()) {
      throw UsageError(unknown_name("structure", name, known));
    }
  }
  for (std::string_view name : known) {
    if (o.structures.empty() || is_asked("all") || is_asked(name)) chosen.emplace_back(name);
  }
  o.structures = std::move(chosen);
}

void check_families(Options& o) {
  std::vector<std::string_view> known;
  for (const HardFamily& family : hard_families()) known.push_back(family.name);
  for (const std::string& name : o.families) {
    if (name != "all" && find_hard_family(name) == nullptr) {
      throw UsageError(unknown_name("family", name, known));
    }
  }
  const auto is_asked = [&](std::string_view name) {
    return std::find(o.families.begin(), o.families.end(), name) != o.families.end();
  };
  std::vector<std::string> chosen;
  for (std::string_view name : known) {
    if (o.families.empty() || is_asked("all") || is_asked(name)) chosen.emplace_back(name);
  }
  o.families = std::move(chosen);
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

void check_range(const char* option, std::size_t value, std::size_t most) {
  if (value < 1 || value > most)
    throw UsageError(fmt::format("{} must be 1 to {}, not {}.", option, most, value));
}

void check_threads(Options& o) {
  std::vector<unsigned>& counts = o.thread_counts;
  if (counts.empty()) counts = {o.threads};
  for (unsigned count : counts) check_range("--threads", count, usable_core_count());
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  o.threads = counts.back();
}

void check_trace(Arguments& a) {
  check_structures(a.options);
  check_rays(a);
  check_threads(a.options);
  check_range("--count", a.options.count, kMostRays);
  check_range("--repeats", a.options.repeats, kMostRepeats);
  if (!(a.options.build_budget_s >= 0) || !std::isfinite(a.options.build_budget_s)) {
    throw UsageError(
        fmt::format("--build-budget must be at least 0 seconds, not {}.", a.options.build_budget_s));
  }
  if (!a.json.empty()) a.options.json = a.json;
}

void check_hard(Arguments& a, const CLI::App& command) {
  if (a.options.structures.empty()) {
    a.options.structures.assign(kHardStructures.begin(), kHardStructures.end());
  }
  if (command.count("--count") == 0) a.options.count = kDefaultHardRays;
  check_families(a.options);
  check_trace(a);
}

void check_pareto(Arguments& a, const CLI::App& command) {
  if (a.options.structures.empty()) {
    a.options.structures.assign(kParetoStructures.begin(), kParetoStructures.end());
  }
  if (command.count("--count") == 0) a.options.count = kDefaultParetoRays;
  if (command.count("--plot") > 0) {
    if (a.json.empty()) throw UsageError("--plot needs --json: the plot is made from the records.");
    a.options.plot = a.plot;
  }
  check_trace(a);
}

void check_picture(Arguments& a, const CLI::App& command) {
  Options& o = a.options;
  o.directory = a.directory;
  if (command.count("--size") > 0) {
    const auto [width, height] = parse_pair(a.size, 'x', "--size");
    const auto is_side = [](double s) {
      return s >= 1 && s <= double{kMaxPictureSide} && s == std::floor(s);
    };
    if (!is_side(width) || !is_side(height)) {
      throw UsageError(
          fmt::format("--size must be WxH of 1 to {} pixels, not \"{}\".", kMaxPictureSide, a.size));
    }
    o.picture_width = static_cast<std::size_t>(width);
    o.picture_height = static_cast<std::size_t>(height);
  }
  check_range("--spp", o.samples_per_pixel, 65536);
}

void add_bench(CLI::App& app, Arguments& a) {
  CLI::App& bench =
      *app.add_subcommand("bench", "Build each structure, trace the same rays interleaved, compare");
  add_scene_options(bench, a);
  add_trace_options(bench, a, kDefaultBenchRays);
  bench
      .add_option("--threads", a.options.thread_counts,
                  "Threads, each pinned to a core; several counts, separated by commas: speeds with each of "
                  "them, builds with the largest")
      ->delimiter(',')
      ->default_str("all cores");
  bench.add_option("--repeats", a.options.repeats, "Times that each ray set is traced")
      ->capture_default_str();
  bench
      .add_option("--build-budget", a.options.build_budget_s,
                  "Seconds within which a structure is built again, for the median; 0: built once")
      ->capture_default_str();
}

void add_error(CLI::App& app, Arguments& a) {
  CLI::App& error =
      *app.add_subcommand("error", "Hold what each structure answers against brute force in double");
  add_scene_options(error, a);
  add_trace_options(error, a, kDefaultErrorRays);
  add_threads_option(error, a);
}

std::string names_of(std::span<const std::string_view> structures) {
  std::string names;
  for (std::string_view name : structures) names += (names.empty() ? "" : ",") + std::string(name);
  return names;
}

void add_hard(CLI::App& app, Arguments& a) {
  CLI::App& hard = *app.add_subcommand(
      "hard", "Hold what each structure answers to the catalogue of hard cases against the oracle");
  add_common_options(hard, a, names_of(kHardStructures));
  add_threads_option(hard, a);
  hard.add_option("--families", a.options.families,
                  "Families of hard cases (see list), or all; separated by commas")
      ->delimiter(',')
      ->default_str("all");
  hard.add_option("--count", a.options.count, "Rays of each family")
      ->default_str(std::to_string(kDefaultHardRays));
  hard.add_option("--seed", a.options.seed, "Seed of scenes and rays")->capture_default_str();
}

void add_pareto(CLI::App& app, Arguments& a) {
  CLI::App& pareto = *app.add_subcommand(
      "pareto", "Speed against error: scenes for speed, hard cases for error, a point for each structure");
  add_scene_options(pareto, a);
  add_common_options(pareto, a, names_of(kParetoStructures));
  add_threads_option(pareto, a);
  pareto.add_option("--count", a.options.count, "Rays of each family of hard cases")
      ->default_str(std::to_string(kDefaultParetoRays));
  pareto.add_option("--repeats", a.options.repeats, "Times that each ray set is traced")
      ->capture_default_str();
  pareto.add_option("--plot", a.plot, "PNG file for the plot; needs --json and python3-matplotlib");
}

void add_picture(CLI::App& app, Arguments& a) {
  CLI::App& picture = *app.add_subcommand("picture", "Write a shaded, motion-blurred PNG of each scene");
  add_scene_options(picture, a);
  picture.add_option("-o,--output", a.directory, "Directory for the pictures")->required();
  picture.add_option("--size", a.size, "WxH in pixels")->default_str("960x540");
  picture.add_option("--spp", a.options.samples_per_pixel, "Samples for each pixel")->capture_default_str();
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Arguments a;
  a.options.threads = usable_core_count();
  CLI::App app("Our STBVH against Embree's own tree and LBVHs: speed, memory, and error against an oracle.",
               "stbvh-ab");
  app.set_version_flag("--version", built_commit());
  app.require_subcommand(1);
  app.add_subcommand("list", "Names of scenes, structures and kinds of rays");
  add_bench(app, a);
  add_error(app, a);
  add_hard(app, a);
  add_pareto(app, a);
  add_picture(app, a);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {
      app.exit(e);
      return std::nullopt;
    }
    throw UsageError(e.what());
  }
  const CLI::App& command = *app.get_subcommands().front();
  const std::string name = command.get_name();
  if (name == "list") return a.options;
  if (name == "hard") {
    a.options.command = Command::kHard;
    check_hard(a, command);
    return a.options;
  }
  check_scenes(a, command);
  if (name == "pareto") {
    a.options.command = Command::kPareto;
    check_pareto(a, command);
    return a.options;
  }
  if (name == "picture") {
    a.options.command = Command::kPicture;
    check_picture(a, command);
    return a.options;
  }
  a.options.command = name == "bench" ? Command::kBench : Command::kError;
  if (command.count("--count") == 0)
    a.options.count = name == "bench" ? kDefaultBenchRays : kDefaultErrorRays;
  check_trace(a);
  return a.options;
}

}  // namespace stbvh::harness
