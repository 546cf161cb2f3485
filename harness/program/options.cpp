#include "harness/program/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "harness/program/closest_name.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/usage_error.h"
#include "harness/program/whole_numbers.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/reach.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostRepeats = 10'000;
constexpr std::size_t kMostRays = 100'000'000;

bool contains(std::span<const std::string> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<RayKind> chosen_rays(const std::vector<std::string>& asked) {
  std::vector<std::string_view> known;
  for (RayKind kind : ray_kinds()) known.push_back(ray_kind_name(kind));
  for (const std::string& name : asked) index_of("kind of rays", name, known);
  std::vector<RayKind> rays;
  for (RayKind kind : ray_kinds()) {
    if (contains(asked, ray_kind_name(kind))) rays.push_back(kind);
  }
  return rays;
}

template <class Threads>
void take_threads(CLI::App& app, Threads& threads, const char* description) {
  const auto take = [&threads](std::size_t count) {
    check_range("--threads", count, usable_core_count());
    threads = static_cast<unsigned>(count);
  };
  add_whole_number_option(app, "--threads", take, description)->default_str("all cores");
}

}  // namespace

bool parse_command_line(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
  } catch (const CLI::CallForAllHelp&) {
    fmt::print("{}", app.help("", CLI::AppFormatMode::All));
  } catch (const CLI::CallForVersion& version) {
    fmt::print("{}\n", version.what());
  } catch (const CLI::ParseError& e) {
    throw UsageError(e.what());
  }
  return false;
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

std::size_t index_of(std::string_view what, std::string_view name, std::span<const std::string_view> known) {
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end()) throw UsageError(unknown_name(what, name, known));
  return static_cast<std::size_t>(found - known.begin());
}

std::vector<std::string> chosen_names(std::string_view what, const std::vector<std::string>& asked,
                                      std::span<const std::string_view> known) {
  for (const std::string& name : asked) {
    if (name != "all") index_of(what, name, known);
  }
  std::vector<std::string> chosen;
  for (std::string_view name : known) {
    if (asked.empty() || contains(asked, "all") || contains(asked, name)) chosen.emplace_back(name);
  }
  return chosen;
}

std::vector<std::string> chosen_structures(const std::vector<std::string>& asked) {
  // Those of the gallery go behind the others; "all" does not mean them.
  std::vector<std::string> others, chosen;
  for (const std::string& name : asked) {
    if (!is_in_gallery(name)) others.push_back(name);
  }
  if (!others.empty() || asked.empty()) chosen = chosen_names("structure", others, structure_names());
  for (const std::string_view name : gallery_names()) {
    if (contains(asked, name)) chosen.emplace_back(name);
  }
  return chosen;
}

void check_range(const char* option, std::size_t value, std::size_t most) {
  if (value < 1 || value > most)
    throw UsageError(fmt::format("{} must be 1 to {}, not {}.", option, most, value));
}

CLI::Option* add_number_option(CLI::App& app, const char* name, std::size_t& value, std::size_t most,
                               const char* description) {
  const auto take = [=, &value](std::size_t number) {
    check_range(name, number, most);
    value = number;
  };
  return add_whole_number_option(app, name, take, description)->default_str(std::to_string(value));
}

CLI::Option* add_structures_option(CLI::App& app, std::vector<std::string>& structures,
                                   std::span<const std::string_view> otherwise, const char* description) {
  using Names = std::vector<std::string>;
  const auto choose = [&structures](const Names& asked) { structures = chosen_structures(asked); };
  choose(Names(otherwise.begin(), otherwise.end()));
  return app.add_option_function<Names>("--structures", choose, description)
      ->delimiter(',')
      ->default_str(otherwise.empty() ? "all" : fmt::format("{}", fmt::join(otherwise, ",")));
}

void add_threads_option(CLI::App& app, unsigned& threads, const char* description) {
  threads = usable_core_count();
  take_threads(app, threads, description);
}

void add_threads_option(CLI::App& app, std::optional<unsigned>& threads, const char* description) {
  take_threads(app, threads, description);
}

namespace {

void add_file_option(CLI::App& app, const char* name, std::optional<std::filesystem::path>& path,
                     const char* description) {
  const auto take = [&path](const std::string& file) {
    if (!file.empty()) path = file;
  };
  app.add_option_function<std::string>(name, take, description);
}

}  // namespace

void add_json_option(CLI::App& app, RecordOptions& records, const char* description) {
  add_file_option(app, "--json", records.json, description);
}

void add_tables_option(CLI::App& app, RecordOptions& records) {
  add_file_option(app, "--tables", records.tables, "File for all tables, of which the screen has a summary");
}

void add_rays_option(CLI::App& app, std::vector<RayKind>& rays) {
  std::vector<std::string_view> names;
  for (RayKind kind : rays) names.push_back(ray_kind_name(kind));
  app.add_option_function<std::vector<std::string>>(
         "--rays", [&rays](const auto& asked) { rays = chosen_rays(asked); },
         "primary, bounce, uniform, shadow, bounce-occluded, uniform-occluded")
      ->delimiter(',')
      ->default_str(fmt::format("[{}]", fmt::join(names, ",")));
}

void add_count_option(CLI::App& app, std::size_t& count, const char* description) {
  add_number_option(app, "--count", count, kMostRays, description);
}

void add_repeats_option(CLI::App& app, std::size_t& repeats) {
  add_number_option(app, "--repeats", repeats, kMostRepeats, "Times that each ray set is traced");
}

void add_samples_option(CLI::App& app, RenderSettings& picture, const char* description) {
  add_number_option(app, "--spp", picture.samples_per_pixel, kMaxSamplesPerPixel, description);
}

void add_size_option(CLI::App& app, RenderSettings& picture, const char* description) {
  const auto take = [&picture](const std::string& text) {
    const auto [width, height] = parse_pair(text, 'x', "--size");
    const auto is_side = [](double s) {
      return s >= 1 && s <= double{kMaxPictureSide} && s == std::floor(s);
    };
    if (!is_side(width) || !is_side(height)) {
      throw UsageError(
          fmt::format("--size must be WxH of 1 to {} pixels, not \"{}\".", kMaxPictureSide, text));
    }
    picture.width = static_cast<std::size_t>(width);
    picture.height = static_cast<std::size_t>(height);
  };
  app.add_option_function<std::string>("--size", take, description)
      ->default_str(fmt::format("{}x{}", picture.width, picture.height));
}

}  // namespace stbvh::harness
