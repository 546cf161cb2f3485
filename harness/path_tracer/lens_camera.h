/// Where the rays of pictures come from: a thin lens, and a shutter.
#pragma once

#include <cstddef>
#include <optional>

#include "harness/path_tracer/sobol_sampler.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

struct Lens {
  double radius = 0;                     ///< in the scene's units; 0: everything is sharp
  std::optional<double> focus_distance;  ///< along the axis; empty: the camera's target is sharp
};

/// How much light the shutter lets through from `open` to `close`: it grows from nothing during the first
/// `opening` of that time and shrinks again during the last `closing` of it. 0 and 0: a box; 0.5 and 0.5: a
/// triangle.
struct Shutter {
  double open = 0;
  double close = 1;
  double opening = 0;
  double closing = 0;

  /// The time up to which the share `number` in [0, 1) of the light has come.
  float time_at(double number) const;
};

/// Throws std::invalid_argument for a shutter outside [0, 1] or that closes before it opens.
void check_shutter(const Shutter& shutter);

struct CameraRay {
  Vec3 origin;
  Vec3 direction;  ///< of length 1
};

/// Pixels count from the upper left corner.
struct PixelPosition {
  double x = 0, y = 0;
};

class LensCamera {
 public:
  /// Throws std::invalid_argument for a camera that looks nowhere or a lens that cannot be.
  LensCamera(const Camera& camera, const Lens& lens, std::size_t width, std::size_t height);

  /// Through `position` in the picture and the point `lens_point` of the lens.
  CameraRay ray(PixelPosition position, SamplePoint lens_point) const;
  /// Where `point` stands in the picture, seen from the middle of the lens; nowhere if it is behind it.
  std::optional<PixelPosition> project(Vec3 point) const;

 private:
  Vec3 origin_, forward_, right_, up_;  ///< right_ and up_: unit vectors
  double half_width_, half_height_;     ///< of the picture at distance 1
  double width_, height_;               ///< in pixels
  double lens_radius_, focus_distance_;
};

}  // namespace stbvh::harness
