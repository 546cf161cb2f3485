#include "harness/cli/render_options.h"

#include <fmt/format.h>

#include <cmath>

#include "harness/cli/usage_error.h"

namespace stbvh::harness {
namespace {

void check_shutter_options(Arguments& a) {
  Shutter& shutter = a.options.render.shutter;
  if (!(shutter.open >= 0 && shutter.open <= shutter.close && shutter.close <= 1)) {
    throw UsageError(
        fmt::format("--shutter-open and --shutter-close must be 0 <= open <= close <= 1, not {} and {}.",
                    shutter.open, shutter.close));
  }
  const double ramp = a.shutter_curve == "triangle" ? 0.5 : a.shutter_curve == "trapezoid" ? 0.25 : 0;
  shutter.opening = shutter.closing = ramp;
}

}  // namespace

void check_size(Arguments& a) {
  const auto [width, height] = parse_pair(a.size, 'x', "--size");
  const auto is_side = [](double s) { return s >= 1 && s <= double{kMaxPictureSide} && s == std::floor(s); };
  if (!is_side(width) || !is_side(height)) {
    throw UsageError(
        fmt::format("--size must be WxH of 1 to {} pixels, not \"{}\".", kMaxPictureSide, a.size));
  }
  a.options.render.width = static_cast<std::size_t>(width);
  a.options.render.height = static_cast<std::size_t>(height);
}

void check_samples(const Arguments& a) {
  const std::size_t samples = a.options.render.samples_per_pixel;
  if (samples < 1 || samples > kMaxSamplesPerPixel) {
    throw UsageError(fmt::format("--spp must be 1 to {}, not {}.", kMaxSamplesPerPixel, samples));
  }
}

void add_render_options(CLI::App& command, Arguments& a) {
  RenderSettings& r = a.options.render;
  command
      .add_option("--structures", a.options.structures,
                  "Names of structures (see list), or all; separated by commas")
      ->delimiter(',')
      ->default_str("stbvh");
  command
      .add_option("-o,--output", a.output,
                  "OpenEXR file; for several scenes or structures a folder of SCENE-STRUCTURE.exr")
      ->required();
  command.add_flag("--png", a.options.png, "Beside each OpenEXR file a PNG to look at");
  command.add_option("--size", a.size, "WxH in pixels")->default_str("960x540");
  command.add_option("--spp", r.samples_per_pixel, "Samples for each pixel")->capture_default_str();
  command.add_option("--threads", a.options.threads, "Threads")->default_str("all cores");
  command.add_option("--environment", a.environment,
                     "OpenEXR picture of latitude and longitude that lights the scene from all sides");
  command.add_option("--shutter-open", r.shutter.open, "Time at which the shutter opens")
      ->capture_default_str();
  command.add_option("--shutter-close", r.shutter.close, "Time at which it closes; the same: no blur")
      ->capture_default_str();
  command
      .add_option("--shutter-curve", a.shutter_curve,
                  "How it opens and closes: box (at once), trapezoid (a quarter of the time each), triangle")
      ->check(CLI::IsMember({"box", "trapezoid", "triangle"}))
      ->capture_default_str();
  command.add_option("--lens-radius", r.lens.radius, "In the scene's units; 0: everything is sharp")
      ->capture_default_str();
  command.add_option("--focus-distance", a.focus_distance, "Distance that is sharp")
      ->default_str("that of the camera's target");
}

void check_render_options(Arguments& a, const CLI::App& command) {
  RenderSettings& r = a.options.render;
  if (command.count("--size") > 0) check_size(a);
  check_samples(a);
  check_shutter_options(a);
  if (!(r.lens.radius >= 0) || !std::isfinite(r.lens.radius)) {
    throw UsageError(fmt::format("--lens-radius must be at least 0, not {}.", r.lens.radius));
  }
  if (command.count("--focus-distance") > 0) {
    if (!(a.focus_distance > 0) || !std::isfinite(a.focus_distance)) {
      throw UsageError(fmt::format("--focus-distance must be above 0, not {}.", a.focus_distance));
    }
    r.lens.focus_distance = a.focus_distance;
  }
  r.seed = a.options.seed;
  r.threads = a.options.threads;
  a.options.environment = a.environment;
  a.options.output = a.output;
}

}  // namespace stbvh::harness
