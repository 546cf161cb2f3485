#include "harness/cli/render_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <stdexcept>
#include <string_view>

#include "harness/program/usage_error.h"
#include "harness/scenes/reach.h"

namespace stbvh::harness {
namespace {

constexpr std::array<std::string_view, 1> kStructure{"stbvh"};

void add_shutter_options(CLI::App& app, Shutter& shutter) {
  app.add_option("--shutter-open", shutter.open, "Time at which the shutter opens")->capture_default_str();
  app.add_option("--shutter-close", shutter.close, "Time at which it closes; the same: no blur")
      ->capture_default_str();
  const auto take_curve = [&shutter](const std::string& curve) {
    shutter.opening = shutter.closing = curve == "triangle" ? 0.5 : curve == "trapezoid" ? 0.25 : 0;
  };
  app.add_option_function<std::string>(
         "--shutter-curve", take_curve,
         "How it opens and closes: box (at once), trapezoid (a quarter of the time each), triangle")
      ->check(CLI::IsMember({"box", "trapezoid", "triangle"}))
      ->default_str("box");
}

/// "2/4".
Strip parse_strip(const std::string& text) {
  std::size_t index = 0, count = 0;
  int end = 0;
  if (text.find_first_not_of("0123456789/") != std::string::npos ||
      std::sscanf(text.c_str(), "%zu/%zu%n", &index, &count, &end) != 2 ||
      end != static_cast<int>(text.size()) || index < 1 || index > count || count > kMaxPictureSide) {
    throw UsageError(fmt::format("--tile: 1/4 to 4/4 are the tiles of four, not \"{}\".", text));
  }
  return {index - 1, count};
}

void add_tile_option(CLI::App& app, Strip& strip) {
  app.add_option_function<std::string>(
         "--tile", [&strip](const std::string& text) { strip = parse_strip(text); },
         "I/N: of the rows of the picture the I-th of N parts; stbvh-ab merge joins them")
      ->default_str("1/1");
}

void add_point_option(CLI::App& app, const char* name, std::optional<Vec3f>& point, const char* description) {
  app.add_option_function<std::string>(
      name, [=, &point](const std::string& text) { point = parse_point(text, name); }, description);
}

void add_camera_options(CLI::App& app, CameraOptions& camera) {
  add_point_option(app, "--camera-position", camera.position,
                   "X,Y,Z instead of the scene's camera, which then stands still");
  add_point_option(app, "--camera-target", camera.target, "X,Y,Z that it looks at, and what is sharp");
  add_point_option(app, "--camera-up", camera.up, "X,Y,Z, the direction that is up in the picture");
  const auto take_fov = [&camera](float degrees) {
    if (!(degrees > 0 && degrees < 180))
      throw UsageError(fmt::format("--fov must be above 0 and below 180 degrees, not {}.", degrees));
    camera.fov_degrees = degrees;
  };
  app.add_option_function<float>("--fov", take_fov, "Its vertical angle of view in degrees");
}

void add_lens_options(CLI::App& app, Lens& lens) {
  const auto take_radius = [&lens](double radius) {
    if (!(radius >= 0) || !is_within_reach(radius)) {
      throw UsageError(
          fmt::format("--lens-radius must be at least 0 and below {}, not {}.", kMaxCoordinate, radius));
    }
    lens.radius = radius;
  };
  app.add_option_function<double>("--lens-radius", take_radius,
                                  "In the scene's units; 0: everything is sharp")
      ->default_str("0");
  const auto take_focus = [&lens](double distance) {
    if (!(distance > 0) || !is_within_reach(distance)) {
      throw UsageError(
          fmt::format("--focus-distance must be above 0 and below {}, not {}.", kMaxCoordinate, distance));
    }
    lens.focus_distance = distance;
  };
  app.add_option_function<double>("--focus-distance", take_focus, "Distance that is sharp")
      ->default_str("that of the camera's target");
}

}  // namespace

void add_options(CLI::App& app, RenderOptions& o) {
  add_scene_options(app, o);
  add_structures_option(app, o.structures, kStructure);
  app.add_option(
         "-o,--output", o.output,
         "OpenEXR file; for several scenes or structures a folder of SCENE-STRUCTURE.exr, for frames of "
         "SCENE-STRUCTURE.FRAME.exr")
      ->required();
  app.add_flag("--png", o.png,
               "Beside each OpenEXR file a PNG to look at; of frames a film, where ffmpeg is");
  add_frame_options(app, o.frames);
  app.add_flag(
      "--resume", o.resume,
      "Leave pictures as they are that are there already, whole, of the same scene, settings and commit");
  add_tile_option(app, o.settings.strip);
  add_json_option(app, o,
                  "File for the records; beside the OpenEXR files SCENE-STRUCTURE*.png of each picture, its "
                  "difference from that of stbvh-direct, and what camera rays meet");
  add_size_option(app, o.settings);
  add_samples_option(app, o.settings, "Samples for each pixel");
  add_threads_option(app, o.settings.threads);
  app.add_option("--environment", o.environment,
                 "OpenEXR picture of latitude and longitude that lights the scene from all sides");
  add_shutter_options(app, o.settings.shutter);
  add_camera_options(app, o.camera);
  add_lens_options(app, o.settings.lens);
}

void check_shutter_times(const Shutter& shutter) {
  if (shutter.open >= 0 && shutter.open <= shutter.close && shutter.close <= 1) return;
  throw UsageError(
      fmt::format("--shutter-open and --shutter-close must be 0 <= open <= close <= 1, not {} and {}.",
                  shutter.open, shutter.close));
}

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

}  // namespace stbvh::harness
