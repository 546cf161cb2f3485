/// What command lines are read with, and the options that several commands have. Options are checked as they
/// are read: all of this throws UsageError.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/path_tracer/render_settings.h"
#include "harness/rays/ray_set.h"
#include "stbvh/vec.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace stbvh::harness {

/// Reads a command line into what was added to `app`; false if help or version was asked for and printed.
bool parse_command_line(CLI::App& app, int argc, const char* const* argv);

/// Where a command writes what it found.
struct RecordOptions {
  std::optional<std::filesystem::path> json;
  std::optional<std::filesystem::path> tables;  ///< file for what does not fit on a screen
  std::string command_line;                     ///< that the options were read from
};

/// What is traced.
struct RayOptions {
  std::vector<RayKind> rays{RayKind::kPrimary, RayKind::kBounce, RayKind::kUniform, RayKind::kShadow};
  std::size_t count = 0;  ///< of each kind
};

std::optional<double> parse_number(std::string_view text);

/// The two numbers on either side of `separator`.
std::pair<double, double> parse_pair(std::string_view text, char separator, std::string_view option);

/// Three numbers with commas between.
Vec3f parse_point(std::string_view text, std::string_view option);

/// That of `known` which has the name.
std::size_t index_of(std::string_view what, std::string_view name, std::span<const std::string_view> known);

/// Those of `known` that are in `asked`, in their order; all where it is empty or says "all".
std::vector<std::string> chosen_names(std::string_view what, const std::vector<std::string>& asked,
                                      std::span<const std::string_view> known);

/// Structures by name: "all" are structure_names(), those of the gallery are in `asked` one by one, or none.
std::vector<std::string> chosen_structures(const std::vector<std::string>& asked);

void check_range(const char* option, std::size_t value, std::size_t most);

/// A number from 1 to `most`; `value` where it is not given.
CLI::Option* add_number_option(CLI::App& app, const char* name, std::size_t& value, std::size_t most,
                               const char* description);

/// Names of structures; `otherwise` where there are none, or all where that is empty.
CLI::Option* add_structures_option(
    CLI::App& app, std::vector<std::string>& structures, std::span<const std::string_view> otherwise = {},
    const char* description = "Names of structures (see list), or all; separated by commas");

inline constexpr const char* kPinnedThreads = "Threads, each pinned to a core; also of the builds";

/// Of the first, all cores where it is not given.
void add_threads_option(CLI::App& app, unsigned& threads, const char* description = "Threads");
void add_threads_option(CLI::App& app, std::optional<unsigned>& threads, const char* description);

void add_json_option(CLI::App& app, RecordOptions& records, const char* description = "File for the records");

/// --tables.
void add_tables_option(CLI::App& app, RecordOptions& records);

void add_rays_option(CLI::App& app, std::vector<RayKind>& rays);

/// `count` rays where it is not given.
void add_count_option(CLI::App& app, std::size_t& count, const char* description = "Rays of each kind");

void add_repeats_option(CLI::App& app, std::size_t& repeats);

/// --spp.
void add_samples_option(CLI::App& app, RenderSettings& picture, const char* description);

/// --size; what `picture` has where it is not given.
void add_size_option(CLI::App& app, RenderSettings& picture, const char* description = "WxH in pixels");

}  // namespace stbvh::harness
