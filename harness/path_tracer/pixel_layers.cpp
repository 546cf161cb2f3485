#include "harness/path_tracer/pixel_layers.h"

#include <array>
#include <string>

namespace stbvh::harness {
namespace {

// In the order in which PixelSums::store gives the numbers.
constexpr std::array kLayers{"R",        "G",        "B",        "variance.R", "variance.G", "variance.B",
                             "albedo.R", "albedo.G", "albedo.B", "normal.X",   "normal.Y",   "normal.Z",
                             "depth.Z",  "time.T",   "motion.X", "motion.Y"};
constexpr std::array kCounterLayers{"nodes.N", "triangles.N"};
constexpr std::array kIdLayers{"mesh.id", "primitive.id", "face.id"};

}  // namespace

void PixelSums::add(const PathSample& sample) {
  rays_ += sample.rays;
  const Color radiance = is_finite(sample.radiance) ? sample.radiance : Color{};
  if (!is_finite(sample.radiance)) ++not_finite_;
  if (count_ == 0) {
    mesh_ = sample.first.mesh;
    prim_ = sample.first.prim;
    face_ = sample.first.face;
  }
  count_ += 1;
  const Color before = radiance - mean_;  // Welford 1962: no difference of large squares
  mean_ = mean_ + (1 / count_) * before;
  squares_ = squares_ + modulate(before, radiance - mean_);
  counters_.nodes += sample.counters.nodes;
  counters_.triangle_tests += sample.counters.triangle_tests;
  if (sample.first.is_hit) add_first_hit(sample);
}

void PixelSums::add_first_hit(const PathSample& sample) {
  const FirstHit& first = sample.first;
  hits_ += 1;
  albedo_ = albedo_ + first.albedo;
  normal_ = normal_ + first.normal;
  depth_ += first.depth;
  time_ += static_cast<double>(sample.time);
  motion_x_ += first.motion_x;
  motion_y_ += first.motion_y;
}

void PixelSums::store(LayeredImage& image, std::size_t pixel) const {
  std::size_t next = 0;
  const auto put = [&](double value) { image.channels[next++].values[pixel] = static_cast<float>(value); };
  const auto put3 = [&](Vec3 v, double scale) {
    put(v.x * scale);
    put(v.y * scale);
    put(v.z * scale);
  };
  const double each = 1 / count_, each_hit = hits_ > 0 ? 1 / hits_ : 0;
  put3(mean_, 1);
  put3(squares_, count_ > 1 ? 1 / (count_ * (count_ - 1)) : 0);
  put3(albedo_, each);
  put3(normal_, each);
  put(depth_ * each_hit);
  put(time_ * each_hit);
  put(motion_x_ * each_hit);
  put(motion_y_ * each_hit);
  if (image.channels.size() > next) {
    put(static_cast<double>(counters_.nodes) * each);
    put(static_cast<double>(counters_.triangle_tests) * each);
  }
  image.id_channels[0].values[pixel] = mesh_;
  image.id_channels[1].values[pixel] = prim_;
  image.id_channels[2].values[pixel] = face_;
}

LayeredImage empty_layers(std::size_t width, std::size_t height, bool with_counters) {
  LayeredImage image{.width = width, .height = height, .channels = {}, .id_channels = {}, .metadata = {}};
  const auto add = [&](const char* name) {
    image.channels.push_back({name, std::vector<float>(width * height)});
  };
  for (const char* name : kLayers) add(name);
  if (with_counters) {
    for (const char* name : kCounterLayers) add(name);
  }
  for (const char* name : kIdLayers) {
    image.id_channels.push_back({name, std::vector<std::uint32_t>(width * height, kInvalidId)});
  }
  return image;
}

std::size_t layer_bytes_per_pixel() {
  return 4 * (kLayers.size() + kCounterLayers.size() + kIdLayers.size());
}

}  // namespace stbvh::harness
