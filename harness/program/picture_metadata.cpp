#include "harness/program/picture_metadata.h"

#include <fmt/format.h>

#include <utility>

#include "harness/report/machine.h"

namespace stbvh::harness {
namespace {

std::string text_of(const Camera& c) {
  return fmt::format("position {},{},{}, target {},{},{}, up {},{},{}, fov {}", c.position.x, c.position.y,
                     c.position.z, c.target.x, c.target.y, c.target.z, c.up.x, c.up.y, c.up.z,
                     c.vertical_fov_degrees);
}

}  // namespace

void add_metadata(const RenderSettings& r, const std::string& scene, const std::string& structure,
                  const std::filesystem::path& environment, Rendering& rendering) {
  const Machine machine = this_machine();
  const auto add = [&](const char* name, std::string value) {
    rendering.image.metadata.emplace_back(name, std::move(value));
  };
  add("scene", scene);
  add("structure", structure);
  add("seed", fmt::format("{}", r.seed));
  add("size", fmt::format("{}x{}", r.width, r.height));
  add("spp", fmt::format("{}", r.samples_per_pixel));
  add("shutter", fmt::format("{} to {}, opening {}, closing {}", r.shutter.open, r.shutter.close,
                             r.shutter.opening, r.shutter.closing));
  if (r.camera) add("camera", text_of(*r.camera));
  add("lens_radius", fmt::format("{}", r.lens.radius));
  if (r.lens.focus_distance) add("focus_distance", fmt::format("{}", *r.lens.focus_distance));
  if (!environment.empty()) add("environment", environment.string());
  add("complete", rendering.is_complete ? "yes" : "no");
  add("not_finite", fmt::format("{}", rendering.not_finite));
  add("seconds", fmt::format("{:.3f}", rendering.seconds));
  add("mrays_per_s", fmt::format("{:.4f}", static_cast<double>(rendering.rays) / 1e6 / rendering.seconds));
  add("threads", fmt::format("{}", r.threads));
  add("machine", fmt::format("{}, {} cores", machine.cpu, machine.cores));
  add("commit", built_commit());
}

}  // namespace stbvh::harness
