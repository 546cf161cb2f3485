#include "harness/preview/preview_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <utility>

#include "harness/cli/check_options.h"
#include "harness/cli/render_options.h"
#include "harness/preview/shown_picture.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/scene_options.h"
#include "harness/program/usage_error.h"
#include "harness/report/machine.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostFrames = 1'000'000;
constexpr std::size_t kLeastSide = 64, kLargestSide = 8192;  // of a window

struct PreviewArguments {
  Arguments scene;
  PreviewOptions preview;
  std::string screenshot, script;
};

void add_options(CLI::App& app, PreviewArguments& a) {
  Arguments& s = a.scene;
  app.add_option(
         "scene", a.preview.scene,
         "Name of a built-in scene (see stbvh-ab list), .glb, .gltf, .xml (Embree's) or .ecs file, or .obj "
         "files (walk_%04d.obj, or a folder)")
      ->capture_default_str();
  const std::size_t others = app.get_options().size();
  add_making_options(app, s);
  const std::vector<CLI::Option*> all = app.get_options();
  s.scene_options.assign(all.begin() + static_cast<std::ptrdiff_t>(others), all.end());
  app.add_option("--structures", s.options.structures, "A, or A,B: the structures that are looked at")
      ->delimiter(',')
      ->default_str("stbvh-direct,embree");
  app.add_option("--size", s.size, "WxH of the window, in pixels")->default_str("1280x800");
  app.add_option("--samples", a.preview.most_samples, "Samples of each pixel at which a picture is done")
      ->capture_default_str();
  app.add_option("--threads", s.options.threads, "Threads that build and render")->default_str("all cores");
  app.add_option("--screenshot", a.screenshot, "PNG file: write the window to it, and end");
  app.add_option("--frames", a.preview.frames,
                 "Of the window, from the first picture on, before --screenshot")
      ->capture_default_str();
  app.add_option("--script", a.script, "File of what to do, line by line (docs/preview.md)");
  app.add_flag("--statistics", a.preview.prints_statistics,
               "Print at the end how long the first picture took, and each frame of the window");
}

PreviewOptions checked(PreviewArguments a, const CLI::App& app) {
  Arguments& s = a.scene;
  check_scene_options(s, app);
  if (s.options.structures.empty()) s.options.structures = {"stbvh-direct", "embree"};
  if (s.options.structures.size() > kSlots) throw UsageError("--structures: A, or A and B.");
  Options known = s.options;  // which would put them into another order
  check_structures(known);
  check_threads(s.options);
  s.options.render.width = 1280;
  s.options.render.height = 800;
  if (app.count("--size") > 0) check_size(s);
  const RenderSettings& r = s.options.render;
  for (std::size_t side : {r.width, r.height}) {
    if (side < kLeastSide || side > kLargestSide)
      throw UsageError(fmt::format("--size: a window has {} to {} pixels a side.", kLeastSide, kLargestSide));
  }
  const std::size_t samples = a.preview.most_samples;
  if (samples < 1 || samples > kMaxSamplesPerPixel)
    throw UsageError(fmt::format("--samples must be 1 to {}, not {}.", kMaxSamplesPerPixel, samples));
  if (a.preview.frames < 1 || a.preview.frames > kMostFrames)
    throw UsageError(fmt::format("--frames must be 1 to {}, not {}.", kMostFrames, a.preview.frames));
  if (app.count("--frames") > 0 && a.screenshot.empty())
    throw UsageError("--frames says when the --screenshot is taken.");
  if (!a.screenshot.empty()) a.preview.screenshot = a.screenshot;
  if (!a.script.empty()) a.preview.script = a.script;
  a.preview.options = s.options;
  return a.preview;
}

}  // namespace

std::optional<PreviewOptions> parse_preview_options(int argc, const char* const* argv) {
  PreviewArguments a;
  a.scene.options.threads = usable_core_count();
  CLI::App app("Scenes in a window, path-traced through our STBVH and others while you look.",
               "stbvh-preview");
  app.set_version_flag("--version", version_text("stbvh-preview"));
  add_options(app, a);
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  return checked(std::move(a), app);
}

}  // namespace stbvh::harness
