#include "harness/scenes/procedural/shared/spoked_wheel.h"

namespace stbvh::harness {
namespace {

Patches about_z(Patches patches) {
  Part turned;
  turned.add(patches, {rotation({1, 0, 0}, kPi / 2), {}, 1});
  return turned.patches;
}

}  // namespace

Patches flat_ring(double inner, double outer, double width, std::size_t around) {
  const double h = width / 2;
  return about_z(lathe({{inner, -h}, {outer, -h}, {outer, h}, {inner, h}, {inner, -h}}, around));
}

WheelPatches make_spoked_wheel(const SpokedWheel& wheel) {
  WheelPatches patches;
  const double inner = wheel.radius - wheel.rim;
  patches.rim = flat_ring(inner, wheel.radius, wheel.width);
  if (wheel.flange > 0) {
    Part flange;
    flange.add(flat_ring(inner, wheel.radius + wheel.flange, 0.25 * wheel.width),
               {translation({0, 0, -0.5 * wheel.width}), {}, 1});
    patches.rim = join({patches.rim, flange.patches});
  }
  for (std::size_t i = 0; i < wheel.spokes; ++i) {
    const double angle = 2 * kPi * static_cast<double>(i) / static_cast<double>(wheel.spokes);
    const Vec3 out{std::cos(angle), std::sin(angle), 0};
    const Patches spoke = cylinder(out * (0.8 * wheel.hub_radius), out * (inner + 0.02 * wheel.radius),
                                   1.25 * wheel.spoke_radius, 0.8 * wheel.spoke_radius, false, 5);
    patches.spokes.insert(patches.spokes.end(), spoke.begin(), spoke.end());
  }
  const double h = wheel.hub_width / 2;
  const double cap = 0.45 * wheel.hub_radius;
  patches.hub = about_z(lathe(
      {{0, -h}, {wheel.hub_radius, -h}, {wheel.hub_radius, h}, {cap, h}, {cap, 1.3 * h}, {0, 1.3 * h}}));
  return patches;
}

Motion spin(Vec3 center, double radians) {
  return rigid_motion([=](double time) { return rotation_about(center, {0, 0, 1}, radians * time); });
}

}  // namespace stbvh::harness
