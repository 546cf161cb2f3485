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

Metadata making_metadata(const RenderSettings& r, const Scene& scene, const std::string& hash,
                         const std::string& structure, const std::filesystem::path& environment) {
  Metadata metadata;
  const auto add = [&](const char* name, std::string value) {
    metadata.emplace_back(name, std::move(value));
  };
  add("scene", scene.name);
  add("scene_hash", hash);
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
  add("commit", built_commit());
  return metadata;
}

void add_outcome(const RenderSettings& r, Rendering& rendering) {
  const Machine machine = this_machine();
  const auto add = [&](const char* name, std::string value) {
    rendering.image.metadata.emplace_back(name, std::move(value));
  };
  add("strip", strip_text(r.strip));
  add("complete", rendering.is_complete ? "yes" : "no");
  add("not_finite", fmt::format("{}", rendering.not_finite));
  add("rays", fmt::format("{}", rendering.rays));
  add("seconds", fmt::format("{:.3f}", rendering.seconds));
  add("mrays_per_s", fmt::format("{:.4f}", static_cast<double>(rendering.rays) / 1e6 / rendering.seconds));
  add("threads", fmt::format("{}", r.threads));
  add("machine", fmt::format("{}, {} cores", machine.cpu, machine.cores));
}

std::string strip_text(const Strip& strip) {
  return fmt::format("{}/{}", strip.index + 1, strip.count);
}

std::string value_of(const Metadata& metadata, std::string_view name) {
  for (const auto& [key, value] : metadata) {
    if (key == name) return value;
  }
  return "";
}

std::string first_difference(const Metadata& wanted, const Metadata& metadata) {
  for (const auto& [name, value] : wanted) {
    if (value_of(metadata, name) != value) return name;
  }
  return "";
}

}  // namespace stbvh::harness
