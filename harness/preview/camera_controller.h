/// A camera that is moved by hand.
#pragma once

#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {

/// Looks along an axis, keeps the horizon level, turns around a pivot. Stays where it is rather than go where
/// no rays come from (is_within_reach()). The camera's target is the point of
/// the axis that is as far away as the pivot: it is what is sharp.
class CameraController {
 public:
  CameraController() : CameraController(Camera{}) {}
  /// The camera's target becomes the pivot.
  explicit CameraController(const Camera& camera);

  Camera camera() const;

  /// Turns around the pivot: to the right, and up until straight above or below it.
  void orbit(double right_degrees, double up_degrees);
  /// Moves camera and pivot sideways; by shares of the picture's height, at the pivot's distance.
  void pan(double right, double up);
  /// Moves towards the pivot: the distance is multiplied with `factor`, above 0.
  void dolly(double factor);
  /// Makes `point` the pivot; nothing moves. Left alone where `point` is not in front of the camera.
  void focus(Vec3 point);
  void set_fov(double degrees);

 private:
  Vec3 right() const { return normalize(cross(forward_, up_)); }

  Vec3 position_, forward_, up_, pivot_;  ///< forward_ and up_: unit vectors
  double fov_degrees_;
};

}  // namespace stbvh::harness
