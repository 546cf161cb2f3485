/// The commands of stbvh-ab and their options.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/path_tracer/render_settings.h"
#include "harness/rays/ray_set.h"
#include "harness/scenes/gltf/gltf.h"

namespace CLI {
class App;
}

namespace stbvh::harness {

/// Rays of each kind where --count is not given.
inline constexpr std::size_t kDefaultBenchRays = 100'000;
inline constexpr std::size_t kDefaultErrorRays = 20'000;
inline constexpr std::size_t kDefaultHardRays = 20'000;
inline constexpr std::size_t kDefaultParetoRays = 100'000;
inline constexpr std::size_t kDefaultScalingRays = 100'000;

enum class Command {
  kList,
  kBench,
  kError,
  kHard,
  kPareto,
  kRender,
  kScaling,
  kCharts,
  kCompare,
  kReport,
  kResults,
  kTruth,
  kConvert
};

/// What a scaling run varies.
enum class Over { kSteps, kTriangles, kThreads };
std::string_view over_name(Over over);

/// What of the scene's camera is replaced.
struct CameraOptions {
  std::optional<Vec3f> position, target, up;
  std::optional<float> fov_degrees;
};

/// All of them checked: names known, numbers in range.
struct Options {
  Command command = Command::kList;
  std::vector<std::string> scenes{"paper"};  ///< names of built-in scenes, and files
  /// The options that say which scenes and how they are made, those that were given, for another command.
  std::vector<std::string> scene_words;
  std::vector<std::string> structures;  ///< in the order of structure_names(); of charts: as named
  std::vector<RayKind> rays;
  std::vector<std::string> families;  ///< of hard cases, in the order of hard_families()
  std::optional<double> scale;        ///< of the paper's scenes; empty: each scene's default
  GltfOptions gltf;
  std::size_t obj_step = 1;  ///< by which the numbers of OBJ sequences go up
  std::uint64_t seed = 1;
  unsigned threads = 1;                 ///< of the builds, and of the rays but where thread_counts has others
  std::vector<unsigned> thread_counts;  ///< that speeds are measured with, ascending; threads is the largest
  std::size_t repeats = 7;
  std::size_t count = 0;
  double build_budget_s = 3;
  std::optional<std::filesystem::path> json;
  std::optional<std::filesystem::path> tables;  ///< file for what does not fit on a screen
  std::optional<std::filesystem::path> plot;    ///< made from the records, so only with json
  Over over = Over::kSteps;
  std::vector<std::size_t> values;        ///< of what a scaling run varies, ascending
  std::vector<std::string> record_files;  ///< that charts draws
  std::filesystem::path picture;          ///< that compare holds against `reference`
  std::filesystem::path reference;
  std::optional<std::filesystem::path> difference_png;
  std::string chart_format = "svg";  ///< or "png"
  std::filesystem::path directory;
  RenderSettings render;              ///< but seed and threads, which stand above
  CameraOptions camera;               ///< of render
  std::filesystem::path output;       ///< of render: a file, or a folder
  std::filesystem::path environment;  ///< OpenEXR file; empty: what the scene brings
  bool png = false;
  std::size_t frozen_times = 1024;            ///< of truth
  std::optional<std::filesystem::path> from;  ///< what report need not measure
  bool quick = false;
  std::string command_line;         ///< that these options were read from
  std::filesystem::path converted;  ///< the file that convert writes, .xml
};

/// Reads a command line into what was added to `app`; false if help or version was asked for and printed.
/// Throws UsageError.
bool parse_command_line(CLI::App& app, int argc, const char* const* argv);

/// Options from a command line; empty if help or version was asked for and printed. Throws UsageError.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace stbvh::harness
