#include "harness/picture/render_picture.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>

#include "harness/picture/embree_scene.h"
#include "harness/picture/picture_math.h"

namespace stbvh::harness {
namespace {

using namespace picture;

constexpr std::size_t kTileSide = 16;
constexpr Vec3f kSunColor{1.65f, 1.55f, 1.35f};
constexpr Vec3f kZenithColor{0.42f, 0.60f, 0.90f};
constexpr Vec3f kHorizonColor{0.86f, 0.91f, 0.97f};
constexpr Vec3f kBelowColor{0.50f, 0.48f, 0.45f};
constexpr float kSunRadius = 0.03f;     // tangent of half the sun's disc: soft edges of shadows
constexpr float kSkyAmbient = 0.72f;    // share of the sky's light that surfaces get
constexpr float kHiddenAmbient = 0.2f;  // the same where the sky is hidden: light that bounced
constexpr float kAmbientReach = 0.35f;  // how far the ambient ray looks, in distances camera to target

/// The camera's frame, with `right` and `up` scaled to half the picture's extent at distance 1.
struct View {
  Vec3f origin, forward, right, up;
  Vec3f world_up;
  float ambient_distance;
};

bool is_finite(Vec3f a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

View make_view(const Camera& camera, const PictureSettings& settings) {
  const Vec3f axis = camera.target - camera.position;
  const Vec3f side = cross(axis, camera.up);
  const float fov = camera.vertical_fov_degrees;
  if (!is_finite(camera.position) || !is_finite(camera.target) || !is_finite(camera.up) ||
      !(length(axis) > 0.0f) || !(length(side) > 0.0f) || !(fov > 0.0f && fov < 180.0f)) {
    throw std::invalid_argument("The scene's camera does not look anywhere.");
  }
  const float half_height = std::tan(fov * std::numbers::pi_v<float> / 360.0f);
  const float aspect = static_cast<float>(settings.width) / static_cast<float>(settings.height);
  View view{};
  view.origin = camera.position;
  view.forward = normalize(axis);
  const Vec3f right = normalize(side);
  view.up = half_height * cross(right, view.forward);
  view.right = (half_height * aspect) * right;
  view.world_up = normalize(camera.up);
  view.ambient_distance = kAmbientReach * length(axis);
  return view;
}

/// The sun stands high behind the camera, to its left, so that what it looks at is lit and casts shadows.
Vec3f sun_direction(const View& view) {
  const Vec3f right = normalize(view.right);
  const Vec3f back = cross(right, view.world_up);
  return normalize(1.0f * view.world_up - 0.62f * right + 0.45f * back);
}

class PictureTracer {
 public:
  PictureTracer(const Scene& scene, const PictureSettings& settings)
      : scene_(scene),
        settings_(settings),
        view_(make_view(scene.camera, settings)),
        sun_(sun_direction(view_)),
        geometry_(scene) {}

  /// Mean of all samples of a pixel, linear.
  Vec3f pixel(std::size_t x, std::size_t y) const {
    Vec3f sum{0, 0, 0};
    const std::size_t samples = settings_.samples_per_pixel;
    for (std::size_t i = 0; i < samples; ++i) {
      const std::uint64_t stream = (y * settings_.width + x) * samples + i;
      SampleRandom random(settings_.seed, stream);
      // Times are stratified: a random one in each of as many equal parts of the shutter as there are
      // samples.
      const float time = (static_cast<float>(i) + random.next()) / static_cast<float>(samples);
      sum = sum + sample(static_cast<float>(x) + random.next(), static_cast<float>(y) + random.next(),
                         std::min(time, 1.0f), random);
    }
    return (1.0f / static_cast<float>(samples)) * sum;
  }

 private:
  Vec3f sample(float x, float y, float time, SampleRandom& random) const {
    const float sx = 2.0f * x / static_cast<float>(settings_.width) - 1.0f;
    const float sy = 1.0f - 2.0f * y / static_cast<float>(settings_.height);
    const Vec3f direction = normalize(view_.forward + sx * view_.right + sy * view_.up);
    const RTCRayHit query = geometry_.intersect(view_.origin, direction, time);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return sky(direction);
    return shade(query, direction, time, random);
  }

  Vec3f shade(const RTCRayHit& query, Vec3f direction, float time, SampleRandom& random) const {
    Vec3f normal{query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z};
    if (!(length(normal) > 0.0f)) normal = -1.0f * direction;
    normal = normalize(normal);
    if (dot(normal, direction) > 0.0f) normal = -1.0f * normal;
    const float offset = 1e-4f * query.ray.tfar;
    const Vec3f point = view_.origin + query.ray.tfar * direction + offset * normal;

    Vec3f light{0, 0, 0};
    const Vec3f to_sun = jittered_sun(random);
    const float cosine = dot(normal, to_sun);
    if (cosine > 0.0f && !geometry_.occluded(point, to_sun, std::numeric_limits<float>::infinity(), time)) {
      light = cosine * kSunColor;
    }
    const Vec3f ambient = cosine_direction(normal, random);
    const bool hidden = geometry_.occluded(point, ambient, view_.ambient_distance, time);
    light = light + (hidden ? kHiddenAmbient : kSkyAmbient) * sky(ambient);
    return light * scene_.meshes[query.hit.geomID].material.color;
  }

  Vec3f jittered_sun(SampleRandom& random) const {
    const Tangents t = tangents_of(sun_);
    const float radius = kSunRadius * std::sqrt(random.next());
    const float angle = 2.0f * std::numbers::pi_v<float> * random.next();
    return normalize(sun_ + (radius * std::cos(angle)) * t.u + (radius * std::sin(angle)) * t.v);
  }

  /// Radiance from a unit direction in which nothing is.
  Vec3f sky(Vec3f direction) const {
    const float height = dot(direction, view_.world_up);
    if (height < 0.0f) return mix(kHorizonColor, kBelowColor, std::min(1.0f, -4.0f * height));
    return mix(kHorizonColor, kZenithColor, std::sqrt(height));
  }

  const Scene& scene_;
  const PictureSettings& settings_;
  View view_;
  Vec3f sun_;
  EmbreeScene geometry_;
};

/// Linear to an sRGB byte, with highlights rolled off instead of cut.
std::uint8_t encode_channel(float linear) {
  constexpr float kShoulder = 0.6f;
  float value = std::max(linear, 0.0f);
  if (value > kShoulder) {
    value = 1.0f - (1.0f - kShoulder) * std::exp(-(value - kShoulder) / (1.0f - kShoulder) * 0.6f);
  }
  const float srgb = value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(srgb, 0.0f, 1.0f)));
}

void check_settings(const PictureSettings& settings) {
  const auto bad_side = [](std::size_t side) { return side == 0 || side > kMaxPictureSide; };
  if (bad_side(settings.width) || bad_side(settings.height)) {
    throw std::invalid_argument(
        fmt::format("A picture of {} x {} pixels cannot be made: each side is 1 to {}.", settings.width,
                    settings.height, kMaxPictureSide));
  }
  if (settings.samples_per_pixel == 0) {
    throw std::invalid_argument("A picture needs at least one sample for each pixel.");
  }
}

}  // namespace

Image render_picture(const Scene& scene, const PictureSettings& settings, const PictureProgress& progress) {
  check_settings(settings);
  const PictureTracer tracer(scene, settings);
  Image image{settings.width, settings.height,
              std::vector<std::uint8_t>(settings.width * settings.height * 3)};

  const std::size_t tiles_x = (settings.width + kTileSide - 1) / kTileSide;
  const std::size_t tiles_y = (settings.height + kTileSide - 1) / kTileSide;
  const std::size_t tiles = tiles_x * tiles_y;
  std::mutex progress_mutex;
  std::size_t tiles_done = 0;
  tbb::parallel_for(std::size_t{0}, tiles, [&](std::size_t tile) {
    const std::size_t x0 = tile % tiles_x * kTileSide, x1 = std::min(x0 + kTileSide, settings.width);
    const std::size_t y0 = tile / tiles_x * kTileSide, y1 = std::min(y0 + kTileSide, settings.height);
    for (std::size_t y = y0; y < y1; ++y) {
      for (std::size_t x = x0; x < x1; ++x) {
        const Vec3f color = tracer.pixel(x, y);
        std::uint8_t* rgb = &image.rgb[(y * settings.width + x) * 3];
        rgb[0] = encode_channel(color.x);
        rgb[1] = encode_channel(color.y);
        rgb[2] = encode_channel(color.z);
      }
    }
    if (progress) {
      const std::lock_guard lock(progress_mutex);
      progress(static_cast<double>(++tiles_done) / static_cast<double>(tiles));
    }
  });
  return image;
}

}  // namespace stbvh::harness
