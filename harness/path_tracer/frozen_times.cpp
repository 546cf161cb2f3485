#include "harness/path_tracer/frozen_times.h"

#include <array>
#include <random>
#include <utility>
#include <vector>

#include "harness/path_tracer/render.h"
#include "harness/scenes/frozen_scene.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

constexpr std::array<const char*, 3> kColors{"R", "G", "B"};

}  // namespace

std::optional<LayeredImage> mean_of_frozen_times(const Scene& scene, std::string_view structure,
                                                 const RenderSettings& settings, std::size_t count,
                                                 const FrozenProgress& progress,
                                                 const std::atomic<bool>* stop) {
  std::array<std::vector<double>, 3> sums;
  for (std::vector<double>& sum : sums) sum.resize(settings.width * settings.height);
  RenderSettings one = settings;
  one.samples_per_pixel = 1;
  one.shutter = {};
  std::mt19937_64 random(settings.seed);
  for (std::size_t i = 0; i < count; ++i) {
    const double within = static_cast<double>(random() >> 11) * 0x1p-53;
    const double time = (static_cast<double>(i) + within) / static_cast<double>(count);
    one.seed = random();
    const Scene still = frozen(scene, static_cast<float>(time));
    const auto built = build_structure(structure, still, settings.threads);
    const Rendering rendering = render(still, *built, one, {}, stop);
    if (!rendering.is_complete) return std::nullopt;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::vector<float>& values = *rendering.image.find(kColors[c]);
      for (std::size_t p = 0; p < values.size(); ++p) sums[c][p] += static_cast<double>(values[p]);
    }
    if (progress) progress(i + 1);
  }
  LayeredImage mean;
  mean.width = settings.width;
  mean.height = settings.height;
  for (std::size_t c = 0; c < 3; ++c) {
    Channel& channel = mean.channels.emplace_back(Channel{kColors[c], {}});
    for (double sum : sums[c]) channel.values.push_back(static_cast<float>(sum / static_cast<double>(count)));
  }
  return mean;
}

}  // namespace stbvh::harness
