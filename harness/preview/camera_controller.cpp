#include "harness/preview/camera_controller.h"

#include <algorithm>
#include <cmath>

#include "harness/scenes/quaternion.h"
#include "harness/scenes/reach.h"

namespace stbvh::harness {
namespace {

/// Between the axis and straight up or down: there the picture has no horizon.
constexpr double kLeastAngle = 0.5 * kPi / 180;
constexpr double kLeastFov = 1, kLargestFov = 150;  // degrees

}  // namespace

CameraController::CameraController(const Camera& camera)
    : position_(to_double(camera.position)),
      forward_(normalize(to_double(camera.target) - position_)),
      up_(normalize(to_double(camera.up))),
      pivot_(to_double(camera.target)),
      fov_degrees_(camera.vertical_fov_degrees) {}

Camera CameraController::camera() const {
  const double distance = dot(pivot_ - position_, forward_);
  return {.position = to_float(position_),
          .target = to_float(position_ + distance * forward_),
          .up = to_float(up_),
          .vertical_fov_degrees = static_cast<float>(fov_degrees_)};
}

void CameraController::orbit(double right_degrees, double up_degrees) {
  const double above = std::acos(std::clamp(dot(forward_, up_), -1.0, 1.0));  // from straight up
  // Going up turns the axis down.
  const double turn = std::clamp(above + up_degrees * kPi / 180, std::min(above, kLeastAngle),
                                 std::max(above, kPi - kLeastAngle)) -
                      above;
  const Quaternion rotation = axis_angle(up_, right_degrees * kPi / 180) * axis_angle(right(), -turn);
  position_ = pivot_ + rotate(rotation, position_ - pivot_);
  forward_ = normalize(rotate(rotation, forward_));
}

void CameraController::pan(double right_share, double up_share) {
  const double height = 2 * dot(pivot_ - position_, forward_) * std::tan(fov_degrees_ * kPi / 360);
  const Vec3 shift = height * (right_share * right() + up_share * cross(right(), forward_));
  if (!is_within_reach(position_ + shift) || !is_within_reach(pivot_ + shift)) return;
  position_ = position_ + shift;
  pivot_ = pivot_ + shift;
}

void CameraController::dolly(double factor) {
  const Vec3 moved = pivot_ + factor * (position_ - pivot_);
  if (is_within_reach(moved)) position_ = moved;
}

void CameraController::focus(Vec3 point) {
  if (dot(point - position_, forward_) > 0) pivot_ = point;
}

void CameraController::set_fov(double degrees) {
  fov_degrees_ = std::clamp(degrees, kLeastFov, kLargestFov);
}

}  // namespace stbvh::harness
