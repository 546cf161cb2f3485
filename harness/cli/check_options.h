/// From what the command line holds to options that can be done.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/cli/options.h"

namespace stbvh::harness {

/// What `hard` compares where it is not told: ours in every layout and instruction set, Embree's in every
/// precision.
inline constexpr std::array<std::string_view, 7> kHardStructures{
    "stbvh-direct", "stbvh-direct-indexed", "stbvh-direct-scalar", "stbvh", "embree", "embree-robust",
    "embree-4v"};
/// What `pareto` compares: each structure in each precision.
inline constexpr std::array<std::string_view, 9> kParetoStructures{
    "embree",     "embree-robust", "embree-4v",        "lbvh", "lbvh-4v", "stbvh",
    "stbvh-fast", "stbvh-direct",  "stbvh-direct-fast"};
inline constexpr double kScalingBuildBudget = 20;  // seconds

/// What the command line holds, before it is checked.
struct Arguments {
  Options options;
  std::vector<const CLI::Option*> scene_options;  ///< of all commands
  std::vector<std::string> rays{"primary", "bounce", "uniform", "shadow"};
  double scale = 0;
  std::string shutter;
  std::string shutter_mode = "clamp";
  std::string steps = "9";
  std::string size;
  std::string json;
  std::string tables;
  std::string plot;
  std::string difference_png;
  std::string from;
  std::string directory;
  std::string converted;
  std::string over;
  std::string scene = "cloth";
  std::string output;
  std::string environment;
  std::string shutter_curve = "box";
  std::string camera_position, camera_target, camera_up;
  float fov_degrees = 0;
  double focus_distance = 0;
};

/// Three numbers with commas between. Throws UsageError, which names `option`.
Vec3f parse_point(std::string_view text, std::string_view option);

/// The two numbers on either side of `separator`. Throws UsageError, which names `option`.
std::pair<double, double> parse_pair(std::string_view text, char separator, std::string_view option);

/// Of the options that say which scene, and how it is made (scene_options.h): `command` has them. Throws
/// UsageError.
void check_scene_options(Arguments& arguments, const CLI::App& command);

/// Makes `structures` those that were asked for, `otherwise` where none was, or all where that is none; in
/// the order of structure_names(). Throws UsageError.
void check_structures(Options& options, std::span<const std::string_view> otherwise = {});

/// Throws UsageError for more threads than there are cores.
void check_threads(Options& options);

/// The options of `command`, the subcommand that `arguments` were read for. Throws UsageError.
Options checked_options(Arguments arguments, const CLI::App& command);

}  // namespace stbvh::harness
