#include "harness/preview/preview_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "harness/preview/shown_picture.h"
#include "harness/program/options.h"
#include "harness/program/usage_error.h"
#include "harness/report/machine.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostFrames = 1'000'000;
constexpr std::size_t kLeastSide = 64, kLargestSide = 8192;  // of a window

void check_window(const RenderSettings& window) {
  for (std::size_t side : {window.width, window.height}) {
    if (side < kLeastSide || side > kLargestSide)
      throw UsageError(fmt::format("--size: a window has {} to {} pixels a side.", kLeastSide, kLargestSide));
  }
}

void choose_structures(const std::vector<std::string>& asked, std::vector<std::string>& structures) {
  if (asked.size() > kSlots) throw UsageError("--structures: A, or A and B.");
  chosen_names("structure", asked, structure_names());
  structures = asked;
}

void add_options(CLI::App& app, PreviewOptions& o, RenderSettings& window) {
  app.add_option("scene", o.scene,
                 "Name of a built-in scene (see stbvh-ab list), .glb, .gltf, .xml (Embree's), .ecs or .stbvh "
                 "file, or .obj "
                 "files (walk_%04d.obj, or a folder)")
      ->capture_default_str();
  add_making_options(app, o);
  o.structures = {"stbvh-direct", "embree"};
  app.add_option_function<std::vector<std::string>>(
         "--structures", [&o](const auto& asked) { choose_structures(asked, o.structures); },
         "A, or A,B: the structures that are looked at")
      ->delimiter(',')
      ->default_str("stbvh-direct,embree");
  add_size_option(app, window, "WxH of the window, in pixels");
  add_number_option(app, "--samples", o.most_samples, kMaxSamplesPerPixel,
                    "Samples of each pixel at which a picture is done");
  add_threads_option(app, o.threads, "Threads that build and render");
  app.add_option_function<std::string>(
      "--screenshot",
      [&o](const auto& file) {
        if (!file.empty()) o.screenshot = file;
      },
      "PNG file: write the window to it, and end");
  add_number_option(app, "--frames", o.frames, kMostFrames,
                    "Of the window, from the first picture on, before --screenshot");
  app.add_option_function<std::string>(
      "--script",
      [&o](const auto& file) {
        if (!file.empty()) o.script = file;
      },
      "File of what to do, line by line (docs/preview.md)");
  app.add_flag("--statistics", o.prints_statistics,
               "Print at the end how long the first picture took, and each frame of the window");
}

}  // namespace

std::optional<PreviewOptions> parse_preview_options(int argc, const char* const* argv) {
  PreviewOptions options;
  RenderSettings window;
  window.width = options.width;
  window.height = options.height;
  CLI::App app("Scenes in a window, path-traced through our STBVH and others while you look.",
               "stbvh-preview");
  app.set_version_flag("--version", version_text("stbvh-preview"));
  add_options(app, options, window);
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  check_window(window);
  if (app.count("--frames") > 0 && !options.screenshot)
    throw UsageError("--frames says when the --screenshot is taken.");
  options.width = window.width;
  options.height = window.height;
  return options;
}

}  // namespace stbvh::harness
