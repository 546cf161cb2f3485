#include "harness/images/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/images/flip.h"
#include "harness/images/tone_map.h"

namespace stbvh::harness {
namespace {

constexpr double kRelativeMseOffset = 0.01;  // keeps black pixels from counting without bound

using Channels = std::array<const std::vector<float>*, 3>;

Channels channels_of(const LayeredImage& image, const char* which) {
  constexpr std::array<const char*, 3> kNames{"R", "G", "B"};
  Channels found{};
  for (std::size_t c = 0; c < 3; ++c) {
    found[c] = image.find(kNames[c]);
    if (found[c] == nullptr)
      throw ComparisonError(fmt::format("The {} has no channel {}.", which, kNames[c]));
  }
  return found;
}

std::array<float, 3> pixel(const Channels& channels, std::size_t i) {
  return {(*channels[0])[i], (*channels[1])[i], (*channels[2])[i]};
}

double squared_difference(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  double total = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double d = static_cast<double>(a[c]) - static_cast<double>(b[c]);
    total += d * d;
  }
  return total;
}

/// Whether each pixel is finite in both pictures.
std::vector<bool> finite_pixels(const Channels& a, const Channels& b, std::size_t count) {
  std::vector<bool> finite(count, true);
  for (const Channels& channels : {a, b}) {
    for (const std::vector<float>* values : channels) {
      for (std::size_t i = 0; i < count; ++i) {
        if (!std::isfinite((*values)[i])) finite[i] = false;
      }
    }
  }
  return finite;
}

/// What a display shows; black where not finite, so that FLIP's filters do not spread it.
DisplayedPicture displayed(const Channels& channels, const LayeredImage& image,
                           const std::vector<bool>& finite) {
  DisplayedPicture shown{.width = image.width, .height = image.height, .rgb = {}};
  for (std::size_t c = 0; c < 3; ++c) {
    shown.rgb[c].resize(finite.size());
    for (std::size_t i = 0; i < finite.size(); ++i) {
      shown.rgb[c][i] = finite[i] ? tone_mapped((*channels[c])[i]) : 0;
    }
  }
  return shown;
}

void add_flip(const Channels& a, const Channels& b, const LayeredImage& image,
              const std::vector<bool>& finite, Comparison& found) {
  found.flip_map = flip(displayed(a, image, finite), displayed(b, image, finite));
  double total = 0;
  for (std::size_t i = 0; i < finite.size(); ++i) {
    if (!finite[i]) {
      found.flip_map[i] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    const auto value = static_cast<double>(found.flip_map[i]);
    total += value;
    found.flip_max = std::max(found.flip_max, value);
  }
  found.flip_mean = total / static_cast<double>(finite.size() - found.not_finite);
}

void add_worst(const Channels& a, const Channels& b, std::vector<std::size_t> differing, Comparison& found) {
  const auto difference = [&](std::size_t i) { return squared_difference(pixel(a, i), pixel(b, i)); };
  const std::size_t kept = std::min(kWorstPixels, differing.size());
  std::partial_sort(differing.begin(), differing.begin() + static_cast<std::ptrdiff_t>(kept), differing.end(),
                    [&](std::size_t i, std::size_t j) {
                      const double di = difference(i);
                      const double dj = difference(j);
                      return di != dj ? di > dj : i < j;
                    });
  for (std::size_t k = 0; k < kept; ++k) {
    const std::size_t i = differing[k];
    found.worst.push_back({i % found.width, i / found.width, pixel(a, i), pixel(b, i)});
  }
}

}  // namespace

Comparison compare(const LayeredImage& picture, const LayeredImage& reference) {
  const Channels a = channels_of(picture, "picture");
  const Channels b = channels_of(reference, "reference");
  if (picture.width != reference.width || picture.height != reference.height) {
    throw ComparisonError(fmt::format("The picture has {} x {} pixels, the reference {} x {}.", picture.width,
                                      picture.height, reference.width, reference.height));
  }
  Comparison found{.width = picture.width, .height = picture.height};
  const std::size_t count = picture.width * picture.height;
  const std::vector<bool> finite = finite_pixels(a, b, count);
  found.not_finite = static_cast<std::size_t>(std::count(finite.begin(), finite.end(), false));
  if (found.not_finite == count) throw ComparisonError("No pixel is finite in both pictures.");
  double squares = 0;
  double relative = 0;
  std::vector<std::size_t> differing;
  for (std::size_t i = 0; i < count; ++i) {
    if (!finite[i]) continue;
    const std::array<float, 3> p = pixel(a, i);
    const std::array<float, 3> r = pixel(b, i);
    if (p != r) differing.push_back(i);
    squares += squared_difference(p, r);
    for (std::size_t c = 0; c < 3; ++c) {
      const double d = static_cast<double>(p[c]) - static_cast<double>(r[c]);
      relative += d * d / (static_cast<double>(r[c]) * static_cast<double>(r[c]) + kRelativeMseOffset);
    }
  }
  const double values = 3.0 * static_cast<double>(count - found.not_finite);
  found.differing = differing.size();
  found.rmse = std::sqrt(squares / values);
  found.relative_mse = relative / values;
  add_flip(a, b, picture, finite, found);
  add_worst(a, b, std::move(differing), found);
  return found;
}

}  // namespace stbvh::harness
