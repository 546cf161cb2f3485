/// The options of `render`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/cli/shot_frames.h"
#include "harness/path_tracer/render_settings.h"
#include "harness/program/options.h"
#include "harness/program/scene_options.h"
#include "harness/program/session.h"

namespace stbvh::harness {

/// What of the scene's camera is replaced.
struct CameraOptions {
  std::optional<Vec3f> position, target, up;
  std::optional<float> fov_degrees;
};

struct RenderOptions : SessionOptions {
  std::vector<std::string> structures;
  std::string output;  ///< a file, or a folder
  bool png = false;
  FrameOptions frames;
  bool resume = false;      ///< pictures that are there already, whole and made alike, are not made again
  RenderSettings settings;  ///< but for the seed, which stands above, and the camera
  CameraOptions camera;
  std::string environment;  ///< OpenEXR file; empty: what the scene brings
};

/// Checks what is read: UsageError.
void add_options(CLI::App& app, RenderOptions& options);

/// Throws UsageError for one that closes before it opens.
void check_shutter_times(const Shutter& shutter);

/// `scene_camera` with what `options` replace of it; empty where that is nothing. Throws
/// UsageError for a camera that looks nowhere.
std::optional<Camera> chosen_camera(const CameraOptions& options, const Camera& scene_camera);

}  // namespace stbvh::harness
