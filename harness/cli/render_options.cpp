#include "harness/cli/render_options.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "harness/cli/usage_error.h"
#include "harness/scenes/reach.h"

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

void check_camera_options(Arguments& a, const CLI::App& command) {
  CameraOptions& camera = a.options.camera;
  if (command.count("--camera-position") > 0)
    camera.position = parse_point(a.camera_position, "--camera-position");
  if (command.count("--camera-target") > 0) camera.target = parse_point(a.camera_target, "--camera-target");
  if (command.count("--camera-up") > 0) camera.up = parse_point(a.camera_up, "--camera-up");
  if (command.count("--fov") == 0) return;
  if (!(a.fov_degrees > 0 && a.fov_degrees < 180))
    throw UsageError(fmt::format("--fov must be above 0 and below 180 degrees, not {}.", a.fov_degrees));
  camera.fov_degrees = a.fov_degrees;
}

}  // namespace

std::optional<Camera> chosen_camera(const CameraOptions& options, const Camera& scene_camera) {
  if (!options.position && !options.target && !options.up && !options.fov_degrees) return std::nullopt;
  const Camera camera{
      .position = options.position.value_or(scene_camera.position),
      .target = options.target.value_or(scene_camera.target),
      .up = options.up.value_or(scene_camera.up),
      .vertical_fov_degrees = options.fov_degrees.value_or(scene_camera.vertical_fov_degrees)};
  try {
    const LensCamera lens(camera, {}, 1, 1);
  } catch (const std::invalid_argument& e) {
    throw UsageError(fmt::format("--camera-position, --camera-target, --camera-up: {}", e.what()));
  }
  return camera;
}

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
  command.add_option(
      "--json", a.json,
      "File for the records; beside the OpenEXR files SCENE-STRUCTURE*.png of each picture, its "
      "difference from that of stbvh-direct, and what camera rays meet");
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
  command.add_option("--camera-position", a.camera_position,
                     "X,Y,Z instead of the scene's camera, which then stands still");
  command.add_option("--camera-target", a.camera_target, "X,Y,Z that it looks at, and what is sharp");
  command.add_option("--camera-up", a.camera_up, "X,Y,Z, the direction that is up in the picture");
  command.add_option("--fov", a.fov_degrees, "Its vertical angle of view in degrees");
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
  check_camera_options(a, command);
  if (!(r.lens.radius >= 0) || !is_within_reach(r.lens.radius)) {
    throw UsageError(
        fmt::format("--lens-radius must be at least 0 and below {}, not {}.", kMaxCoordinate, r.lens.radius));
  }
  if (command.count("--focus-distance") > 0) {
    if (!(a.focus_distance > 0) || !is_within_reach(a.focus_distance)) {
      throw UsageError(fmt::format("--focus-distance must be above 0 and below {}, not {}.", kMaxCoordinate,
                                   a.focus_distance));
    }
    r.lens.focus_distance = a.focus_distance;
  }
  r.seed = a.options.seed;
  r.threads = a.options.threads;
  a.options.environment = a.environment;
  a.options.output = a.output;
  if (!a.json.empty()) a.options.json = a.json;
}

}  // namespace stbvh::harness
