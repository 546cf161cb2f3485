#include "harness/preview/line_drawing.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace stbvh::harness {
namespace {

/// Shares of a segment, from its first to its last point.
struct Part {
  double first = 0, last = 1;
};

/// Of a coordinate that goes from `a` to `b`: where it lies in [0, limit] (Liang and Barsky 1984).
bool clip(double a, double b, double limit, Part& part) {
  const double d = b - a;
  if (d == 0) return a >= 0 && a <= limit;
  const double at_zero = -a / d, at_limit = (limit - a) / d;
  part.first = std::max(part.first, std::min(at_zero, at_limit));
  part.last = std::min(part.last, std::max(at_zero, at_limit));
  return part.first <= part.last;
}

}  // namespace

LineDrawing::LineDrawing(Image& image, const Camera& camera)
    : image_(image),
      lens_(camera, {}, image.width, image.height),
      position_(to_double(camera.position)),
      axis_(normalize(to_double(camera.target) - position_)),
      nearest_(1e-3 * length(to_double(camera.target) - position_)) {}

void LineDrawing::line(Vec3 a, Vec3 b, std::array<std::uint8_t, 3> color) {
  const double depth_a = dot(a - position_, axis_), depth_b = dot(b - position_, axis_);
  if (!(std::max(depth_a, depth_b) > nearest_)) return;
  const double cut = (nearest_ - depth_a) / (depth_b - depth_a);
  if (depth_a < nearest_) {
    a = lerp(a, b, cut);
  } else if (depth_b < nearest_) {
    b = lerp(a, b, cut);
  }
  const auto from = lens_.project(a), to = lens_.project(b);
  if (!from || !to) return;
  Part part;
  if (!clip(from->x, to->x, static_cast<double>(image_.width) - 1, part) ||
      !clip(from->y, to->y, static_cast<double>(image_.height) - 1, part)) {
    return;
  }
  const double dx = to->x - from->x, dy = to->y - from->y;
  const double x0 = from->x + part.first * dx, y0 = from->y + part.first * dy;
  const double x1 = from->x + part.last * dx, y1 = from->y + part.last * dy;
  const auto count = static_cast<std::size_t>(std::ceil(std::max(std::abs(x1 - x0), std::abs(y1 - y0)))) + 1;
  for (std::size_t i = 0; i <= count; ++i) {
    const double f = static_cast<double>(i) / static_cast<double>(count);
    const auto x = static_cast<std::size_t>(std::max(0.0, lerp(x0, x1, f) + 0.5));
    const auto y = static_cast<std::size_t>(std::max(0.0, lerp(y0, y1, f) + 0.5));
    if (x >= image_.width || y >= image_.height) continue;
    std::copy(color.begin(), color.end(), &image_.rgb[3 * (y * image_.width + x)]);
  }
}

}  // namespace stbvh::harness
