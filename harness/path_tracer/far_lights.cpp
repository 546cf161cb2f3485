#include <algorithm>
#include <stdexcept>

#include "harness/path_tracer/directions.h"
#include "harness/path_tracer/lights.h"
#include "harness/scenes/default_sun.h"

namespace stbvh::harness {
namespace {

/// Coordinates of a direction in a picture of latitude and longitude.
SamplePoint latitude_longitude(Vec3 d) {
  const double turn = std::atan2(d.x, -d.z) / (2 * kPi);
  return {turn < 0 ? turn + 1 : turn, std::acos(std::clamp(d.y, -1.0, 1.0)) / kPi};
}

std::size_t cell(double x, std::size_t count) {
  return std::min(static_cast<std::size_t>(x * static_cast<double>(count)), count - 1);
}

}  // namespace

DirectionalLights::DirectionalLights(const std::vector<DirectionalLight>& lights) {
  std::vector<double> weights;
  for (const DirectionalLight& light : lights) {
    const Vec3 direction = to_double(light.direction);
    const Color irradiance = to_double(light.irradiance);
    const double angle = light.half_angle_degrees * kPi / 180;
    if (!is_finite(direction) || !(length(direction) > 0) || !is_light(irradiance) ||
        !(angle >= 0 && angle < kPi / 2)) {
      throw std::invalid_argument("A directional light has no direction, no light or no disc of the sky.");
    }
    const double sine = std::sin(angle), sine_half = std::sin(angle / 2);
    Disc disc{.center = normalize(-direction), .sine2_half = sine_half * sine_half, .radiance = irradiance};
    if (!disc.is_delta()) disc.radiance = (1 / (kPi * sine * sine)) * irradiance;
    discs_.push_back(disc);
    weights.push_back(luminance(irradiance));
  }
  choice_ = Distribution(weights);
  for (std::size_t i = 0; i < discs_.size(); ++i) {
    const double solid_angle = discs_[i].is_delta() ? 1 : 4 * kPi * discs_[i].sine2_half;
    discs_[i].density = choice_.probability(i) / solid_angle;
  }
}

bool DirectionalLights::Disc::holds(Vec3 direction) const {
  const Vec3 chord = direction - center;  // exact in narrow discs, where cosines are all near 1
  return !is_delta() && dot(chord, chord) <= 4 * sine2_half;
}

std::optional<LightSample> DirectionalLights::sample(double choice, SamplePoint point) const {
  if (!(choice_.total() > 0)) return std::nullopt;
  const Disc& disc = discs_[choice_.pick(choice).index];
  if (disc.is_delta()) return LightSample{disc.center, disc.radiance, disc.density, true, std::nullopt};
  const Vec3 local = cone_direction(point, 1 - 2 * disc.sine2_half);
  return LightSample{Frame(disc.center).to_world(local), disc.radiance, disc.density, false, std::nullopt};
}

Vec3 latitude_longitude_direction(double x, double y) {
  const double turn = 2 * kPi * x, sine = std::sin(kPi * y);
  return {sine * std::sin(turn), std::cos(kPi * y), -sine * std::cos(turn)};
}

EnvironmentLight::EnvironmentLight(std::optional<Environment> environment)
    : environment_(std::move(environment)) {
  if (!environment_) return;
  const std::size_t width = environment_->width, height = environment_->height;
  const auto is_bad = [](Vec3f c) { return !is_light(to_double(c)); };
  if (is_bad(environment_->radiance) || environment_->pixels.size() != width * height ||
      std::any_of(environment_->pixels.begin(), environment_->pixels.end(), is_bad)) {
    throw std::invalid_argument("The environment has light that is negative or not finite, or lacks pixels.");
  }
  std::vector<double> row_weights, weights(width);
  for (std::size_t y = 0; y < height; ++y) {
    const double sine = std::sin(kPi * (static_cast<double>(y) + 0.5) / static_cast<double>(height));
    for (std::size_t x = 0; x < width; ++x) {
      // What radiance interpolates across the pixel: 1/8, 6/8, 1/8 of three neighbours each way.
      double sum = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        const std::size_t row = std::clamp<std::size_t>(y + j, 1, height) - 1;
        const double across = luminance(pixel((x + width - 1) % width, row)) + 6 * luminance(pixel(x, row)) +
                              luminance(pixel((x + 1) % width, row));
        sum += (j == 1 ? 6 : 1) * across / 64;
      }
      weights[x] = sum * sine;
    }
    columns_.emplace_back(weights);
    row_weights.push_back(columns_.back().total());
  }
  rows_ = Distribution(row_weights);
}

Color EnvironmentLight::pixel(std::size_t x, std::size_t y) const {
  return modulate(to_double(environment_->radiance),
                  to_double(environment_->pixels[y * environment_->width + x]));
}

Color EnvironmentLight::radiance(Vec3 direction) const {
  if (!environment_) return {};
  if (environment_->width == 0) return to_double(environment_->radiance);
  return radiance_at(latitude_longitude(direction));
}

Color EnvironmentLight::radiance_at(SamplePoint at) const {
  const std::size_t width = environment_->width, height = environment_->height;
  const double x = at.x * static_cast<double>(width) + static_cast<double>(width) - 0.5;
  const double y = std::clamp(at.y * static_cast<double>(height) - 0.5, 0.0, static_cast<double>(height - 1));
  const auto x0 = static_cast<std::size_t>(x), y0 = static_cast<std::size_t>(y);
  const std::size_t y1 = std::min(y0 + 1, height - 1);
  const double fx = x - static_cast<double>(x0), fy = y - static_cast<double>(y0);
  const auto row = [&](std::size_t r) { return lerp(pixel(x0 % width, r), pixel((x0 + 1) % width, r), fx); };
  return lerp(row(y0), row(y1), fy);
}

double EnvironmentLight::density(Vec3 direction) const {
  return rows_.total() > 0 ? density_at(latitude_longitude(direction)) : 0;
}

double EnvironmentLight::density_at(SamplePoint at) const {
  const std::size_t y = cell(at.y, environment_->height), x = cell(at.x, environment_->width);
  const double sine = std::sin(kPi * at.y);
  if (!(sine > 0)) return 0;
  const double pixels = static_cast<double>(environment_->width) * static_cast<double>(environment_->height);
  return rows_.probability(y) * columns_[y].probability(x) * pixels / (2 * kPi * kPi * sine);
}

std::optional<LightSample> EnvironmentLight::sample(SamplePoint point) const {
  if (!(rows_.total() > 0)) return std::nullopt;
  const Distribution::Pick row = rows_.pick(point.y);
  const Distribution::Pick column = columns_[row.index].pick(point.x);
  const SamplePoint at{
      (static_cast<double>(column.index) + column.rest) / static_cast<double>(environment_->width),
      (static_cast<double>(row.index) + row.rest) / static_cast<double>(environment_->height)};
  const double d = density_at(at);
  if (!(d > 0)) return std::nullopt;
  return LightSample{latitude_longitude_direction(at.x, at.y), radiance_at(at), d, false, std::nullopt};
}

DefaultLights sun_and_sky(const Camera& camera) {
  constexpr Vec3f kSunIrradiance{4.6f, 4.3f, 3.8f};
  constexpr float kSunHalfAngle = 1.7f;  // wider than the true sun: shadows with soft edges
  constexpr Color kZenith{0.30, 0.47, 0.80}, kHorizon{0.70, 0.77, 0.86}, kBelow{0.38, 0.36, 0.33};
  constexpr std::size_t kWidth = 64, kHeight = 64;  // smooth, and small enough for the caches
  const Vec3 up = normalize(to_double(camera.up));
  DefaultLights lights{.sun = {to_float(-to_default_sun(camera)), kSunIrradiance, kSunHalfAngle},
                       .sky = {.radiance = {1, 1, 1}, .width = kWidth, .height = kHeight, .pixels = {}}};
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const double height = dot(up, latitude_longitude_direction((static_cast<double>(x) + 0.5) / kWidth,
                                                                 (static_cast<double>(y) + 0.5) / kHeight));
      const Color color = height < 0 ? lerp(kHorizon, kBelow, std::min(1.0, -4 * height))
                                     : lerp(kHorizon, kZenith, std::sqrt(height));
      lights.sky.pixels.push_back(to_float(color));
    }
  }
  return lights;
}

}  // namespace stbvh::harness
