/// Tiles of one picture, rendered apart, as one file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/cli/picture_files.h"
#include "harness/images/exr_file.h"
#include "harness/images/png_file.h"
#include "harness/images/tone_map.h"
#include "harness/program/picture_metadata.h"
#include "harness/program/progress.h"
#include "harness/program/usage_error.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

struct MergeOptions {
  std::vector<std::string> tiles;
  std::string output;
  bool png = false;
};

void add_options(CLI::App& app, MergeOptions& o) {
  app.add_option("tiles", o.tiles, "OpenEXR files of render --tile: all of one picture, in any order")
      ->required();
  app.add_option("-o,--output", o.output, "OpenEXR file of the whole picture")->required();
  app.add_flag("--png", o.png, "Beside it a PNG to look at");
}

struct TileFile {
  std::string name;
  LayeredImage image;
};

/// Without what may differ from tile to tile.
Metadata of_the_picture(const Metadata& metadata) {
  constexpr std::array kOfTheRun{"strip",   "rays",    "seconds",   "mrays_per_s",
                                 "threads", "machine", "not_finite"};
  Metadata result;
  for (const auto& entry : metadata) {
    if (std::ranges::find(kOfTheRun, entry.first) == kOfTheRun.end()) result.push_back(entry);
  }
  return result;
}

std::vector<std::string> channel_names(const LayeredImage& image) {
  std::vector<std::string> names;
  for (const Channel& channel : image.channels) names.push_back(channel.name);
  for (const IdChannel& channel : image.id_channels) names.push_back(channel.name);
  return names;
}

void check_tile(const TileFile& tile) {
  const Metadata& metadata = tile.image.metadata;
  if (value_of(metadata, "strip").empty() || value_of(metadata, "scene_hash").empty())
    throw UsageError(fmt::format("\"{}\" is no tile of stbvh-ab render.", tile.name));
  if (value_of(metadata, "complete") != "yes")
    throw UsageError(fmt::format("\"{}\" is not complete: its rendering was interrupted.", tile.name));
}

void check_alike(const TileFile& a, const TileFile& b) {
  const Metadata of_a = of_the_picture(a.image.metadata), of_b = of_the_picture(b.image.metadata);
  std::string differs = first_difference(of_a, of_b);
  if (differs.empty()) differs = first_difference(of_b, of_a);
  if (!differs.empty()) {
    throw UsageError(fmt::format("\"{}\" and \"{}\" are not of one picture: {} is \"{}\" and \"{}\".", a.name,
                                 b.name, differs, value_of(of_a, differs), value_of(of_b, differs)));
  }
  if (a.image.display_window() != b.image.display_window() || a.image.width != b.image.width ||
      channel_names(a.image) != channel_names(b.image)) {
    throw UsageError(
        fmt::format("\"{}\" and \"{}\" have not the same layers and display window.", a.name, b.name));
  }
}

/// That they are made alike, and that together they are one picture; orders them from its top down.
void check_tiles(std::vector<TileFile>& tiles) {
  for (const TileFile& tile : tiles) check_tile(tile);
  for (const TileFile& tile : tiles) check_alike(tiles.front(), tile);
  std::ranges::sort(tiles, {}, [](const TileFile& tile) { return tile.image.top; });
  const PixelWindow whole = tiles.front().image.display_window();
  const auto expect = [](std::int64_t next, std::int64_t top) {
    if (next < top) throw UsageError(fmt::format("Rows {} to {} are in none of the tiles.", next, top - 1));
  };
  std::int64_t next = whole.top;
  for (const TileFile& tile : tiles) {
    const PixelWindow window = tile.image.window();
    expect(next, window.top);
    if (window.top < next || window.bottom() > whole.bottom())
      throw UsageError(fmt::format("\"{}\" has rows that another tile has too.", tile.name));
    next = window.bottom();
  }
  expect(next, whole.bottom());
}

/// What the whole would say: of its run the sums of those of its tiles.
Metadata merged_metadata(const std::vector<TileFile>& tiles) {
  Metadata metadata = of_the_picture(tiles.front().image.metadata);
  std::uint64_t rays = 0, not_finite = 0;
  double seconds = 0;
  std::vector<std::string> machines;
  for (const TileFile& tile : tiles) {
    const auto of = [&](const char* name) { return value_of(tile.image.metadata, name); };
    rays += std::strtoull(of("rays").c_str(), nullptr, 10);
    not_finite += std::strtoull(of("not_finite").c_str(), nullptr, 10);
    seconds += std::strtod(of("seconds").c_str(), nullptr);
    if (std::ranges::find(machines, of("machine")) == machines.end()) machines.push_back(of("machine"));
  }
  metadata.emplace_back("strip", strip_text({}));
  metadata.emplace_back("tiles", fmt::format("{}", tiles.size()));
  metadata.emplace_back("not_finite", fmt::format("{}", not_finite));
  metadata.emplace_back("rays", fmt::format("{}", rays));
  metadata.emplace_back("seconds", fmt::format("{:.3f}", seconds));
  metadata.emplace_back("machine", fmt::format("{}", fmt::join(machines, "; ")));
  return metadata;
}

template <typename Channels>
void append(Channels& whole, const Channels& tile) {
  for (std::size_t i = 0; i < whole.size(); ++i)
    whole[i].values.insert(whole[i].values.end(), tile[i].values.begin(), tile[i].values.end());
}

LayeredImage merged(std::vector<TileFile>& tiles) {
  check_tiles(tiles);
  Metadata metadata = merged_metadata(tiles);
  LayeredImage whole = std::move(tiles.front().image);
  whole.height = whole.display_window().height;
  whole.metadata = std::move(metadata);
  for (const TileFile& tile : std::span(tiles).subspan(1)) {
    append(whole.channels, tile.image.channels);
    append(whole.id_channels, tile.image.id_channels);
  }
  return whole;
}

void run_merge(const MergeOptions& options) {
  const fs::path output = options.output;
  check_picture_file(output, options.png);
  Progress progress;
  std::vector<TileFile> tiles;
  for (const std::string& name : options.tiles) {
    progress.stage(fmt::format("reading {}", name));
    tiles.push_back({name, read_exr(name)});
  }
  progress.clear();
  const LayeredImage whole = merged(tiles);
  write_exr(whole, output);
  if (options.png) write_png(tone_mapped(whole), png_beside(output));
  fmt::print("{} ({} tiles, rendered in {} s)\n", options.output, tiles.size(),
             value_of(whole.metadata, "seconds"));
}

}  // namespace

Work merge_command(CLI::App& app) {
  return make_work(app, run_merge);
}

}  // namespace stbvh::harness
