#include "harness/path_tracer/lens_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "harness/path_tracer/color.h"
#include "harness/path_tracer/directions.h"
#include "harness/scenes/reach.h"

namespace stbvh::harness {

void check_shutter(const Shutter& s) {
  if (!(s.open >= 0 && s.open <= s.close && s.close <= 1)) {
    throw std::invalid_argument("The shutter must open at 0 or later, and close at 1 or before, after that.");
  }
  if (!(s.opening >= 0 && s.closing >= 0 && s.opening + s.closing <= 1)) {
    throw std::invalid_argument("The shutter's opening and closing must fit into the time that it is open.");
  }
}

float Shutter::time_at(double number) const {
  // Light that comes while it opens, is open, closes; the inverse of a parabola, a line, a parabola.
  const double all = 1 - 0.5 * (opening + closing);
  const double light = number * all;
  const double left = all - light;
  double fraction = light + 0.5 * opening;
  if (light < 0.5 * opening) fraction = std::sqrt(2 * light * opening);
  if (left < 0.5 * closing) fraction = 1 - std::sqrt(2 * left * closing);
  return static_cast<float>(std::clamp(lerp(open, close, fraction), open, close));
}

LensCamera::LensCamera(const Camera& camera, const Lens& lens, std::size_t width, std::size_t height)
    : origin_(to_double(camera.position)),
      width_(static_cast<double>(width)),
      height_(static_cast<double>(height)),
      lens_radius_(lens.radius) {
  const Vec3 axis = to_double(camera.target) - origin_;
  const Vec3 side = cross(axis, to_double(camera.up));
  const double fov = camera.vertical_fov_degrees;
  if (const std::string_view problem = problem_of(camera); !problem.empty())
    throw std::invalid_argument(fmt::format("The camera {}.", problem));
  focus_distance_ = lens.focus_distance.value_or(length(axis));
  if (!(lens_radius_ >= 0) || !is_within_reach(lens_radius_) || !(focus_distance_ > 0) ||
      !std::isfinite(focus_distance_)) {
    throw std::invalid_argument("The lens must have a radius of at least 0, and focus in front of it.");
  }
  forward_ = normalize(axis);
  right_ = normalize(side);
  up_ = cross(right_, forward_);
  half_height_ = std::tan(fov * kPi / 360);
  half_width_ = half_height_ * width_ / height_;
}

CameraRay LensCamera::ray(PixelPosition position, SamplePoint lens_point) const {
  const double x = half_width_ * (2 * position.x / width_ - 1);
  const double y = half_height_ * (1 - 2 * position.y / height_);
  const Vec3 through = forward_ + x * right_ + y * up_;
  if (lens_radius_ == 0) return {origin_, normalize(through)};
  const Vec3 d = lens_radius_ * disc_point(lens_point);
  const Vec3 shift = d.x * right_ + d.y * up_;
  return {origin_ + shift, normalize(focus_distance_ * through - shift)};
}

std::optional<PixelPosition> LensCamera::project(Vec3 point) const {
  const Vec3 d = point - origin_;
  const double depth = dot(d, forward_);
  if (!(depth > 0)) return std::nullopt;
  return PixelPosition{0.5 * width_ * (1 + dot(d, right_) / (depth * half_width_)),
                       0.5 * height_ * (1 - dot(d, up_) / (depth * half_height_))};
}

}  // namespace stbvh::harness
