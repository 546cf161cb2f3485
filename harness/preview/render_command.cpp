#include "harness/preview/render_command.h"

#include <fmt/format.h>

#include <filesystem>

#include "harness/program/scene_options.h"

namespace stbvh::harness {
namespace {

std::string text_of(Vec3f p) {
  return fmt::format("{},{},{}", p.x, p.y, p.z);
}

}  // namespace

std::string render_command(const MakingOptions& options, const std::string& scene,
                           const std::array<std::string, kSlots>& structures,
                           const RenderSettings& settings) {
  const bool is_pair = !structures[1].empty() && structures[1] != structures[0];
  std::string text =
      fmt::format("stbvh-ab render --scenes {} --structures {}", shell_word(scene), structures[0]);
  if (is_pair) text += "," + structures[1];
  for (const std::string& word : options.scene_words) text += fmt::format(" {}", shell_word(word));
  text +=
      fmt::format(" --size {}x{} --spp {} --shutter-open {} --shutter-close {}", settings.width,
                  settings.height, settings.samples_per_pixel, settings.shutter.open, settings.shutter.close);
  if (settings.camera) {
    const Camera& c = *settings.camera;
    // A number may begin with a minus, which must not be taken for an option.
    text += fmt::format(" --camera-position={} --camera-target={} --camera-up={} --fov {}",
                        text_of(c.position), text_of(c.target), text_of(c.up), c.vertical_fov_degrees);
  }
  if (settings.lens.radius > 0) text += fmt::format(" --lens-radius {}", settings.lens.radius);
  const std::string stem = std::filesystem::path(scene).stem().string();
  return text + fmt::format(" -o {}", shell_word(is_pair ? stem + "-pictures" : stem + ".exr"));
}

}  // namespace stbvh::harness
