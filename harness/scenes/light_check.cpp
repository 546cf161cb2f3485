#include "harness/scenes/light_check.h"

#include <fmt/format.h>

#include <cmath>

namespace stbvh::harness {

std::string flaw_of(Vec3f color) {
  const auto is_light = [](float x) { return std::isfinite(x) && x >= 0; };
  if (is_light(color.x) && is_light(color.y) && is_light(color.z)) return {};
  return fmt::format("shines with {} {} {}: each must be finite, and 0 or more", color.x, color.y, color.z);
}

std::string flaw_of(const DirectionalLight& light) {
  const Vec3f& d = light.direction;
  if (!std::isfinite(d.x) || !std::isfinite(d.y) || !std::isfinite(d.z) || (d.x == 0 && d.y == 0 && d.z == 0))
    return "has no direction";
  if (light.half_angle_degrees != 0 && !is_half_angle(light.half_angle_degrees))
    return fmt::format("has a half angle of {} degrees, which is not above 0 and up to 90",
                       light.half_angle_degrees);
  return flaw_of(light.irradiance);
}

}  // namespace stbvh::harness
