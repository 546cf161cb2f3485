#include "harness/images/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <set>

#include "harness/images/flip.h"
#include "harness/images/tone_map.h"

namespace stbvh::harness {
namespace {

constexpr double kRelativeMseOffset = 0.01;  // keeps black pixels from counting without bound

/// R, G and B of the pixels that are compared.
using Channels = std::array<std::vector<float>, 3>;

/// The values of a channel in `part`, which lies in the image.
std::vector<float> cropped(const std::vector<float>& values, const LayeredImage& image,
                           const PixelWindow& part) {
  std::vector<float> found;
  found.reserve(part.width * part.height);
  const auto x = static_cast<std::size_t>(part.left - image.left);
  const auto y = static_cast<std::size_t>(part.top - image.top);
  for (std::size_t row = y; row < y + part.height; ++row) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(row * image.width + x);
    found.insert(found.end(), first, first + static_cast<std::ptrdiff_t>(part.width));
  }
  return found;
}

Channels channels_of(const LayeredImage& image, const PixelWindow& part, const char* which) {
  constexpr std::array<const char*, 3> kNames{"R", "G", "B"};
  Channels found;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float>* values = image.find(kNames[c]);
    if (values == nullptr)
      throw ComparisonError(fmt::format("The {} has no channel {} of floats.", which, kNames[c]));
    found[c] = cropped(*values, image, part);
  }
  return found;
}

std::array<float, 3> pixel(const Channels& channels, std::size_t i) {
  return {channels[0][i], channels[1][i], channels[2][i]};
}

bool is_finite(const std::array<float, 3>& color) {
  return std::all_of(color.begin(), color.end(), [](float v) { return std::isfinite(v); });
}

bool are_same(float x, float y) {
  return x == y || (std::isnan(x) && std::isnan(y));
}

/// Where both have pixels.
PixelWindow common_window(const PixelWindow& a, const PixelWindow& b) {
  const std::int64_t left = std::max(a.left, b.left), top = std::max(a.top, b.top);
  const std::int64_t right = std::min(a.right(), b.right()), bottom = std::min(a.bottom(), b.bottom());
  if (left >= right || top >= bottom) return {left, top, 0, 0};
  return {left, top, static_cast<std::size_t>(right - left), static_cast<std::size_t>(bottom - top)};
}

std::string describe(const PixelWindow& w) {
  return fmt::format("{} x {} pixels from ({}, {}) on", w.width, w.height, w.left, w.top);
}

bool fills_its_display(const LayeredImage& image) {
  return image.window() == image.display_window();
}

/// What is compared of two pictures.
PixelWindow checked_window(const LayeredImage& picture, const LayeredImage& reference) {
  const PixelWindow a = picture.window(), b = reference.window();
  if (fills_its_display(picture) && fills_its_display(reference) && a.left == b.left && a.top == b.top &&
      a != b) {
    throw ComparisonError(fmt::format("The picture has {} x {} pixels, the reference {} x {}.", a.width,
                                      a.height, b.width, b.height));
  }
  const PixelWindow common = common_window(a, b);
  if (common.width == 0) {
    throw ComparisonError(
        fmt::format("The picture has {}, the reference {}: there is no place where both have pixels.",
                    describe(a), describe(b)));
  }
  return common;
}

/// Names of channels that `other` lacks.
std::vector<std::string> only_in(const LayeredImage& image, const LayeredImage& other) {
  const auto names_of = [](const LayeredImage& of) {
    std::set<std::string> names;
    for (const Channel& channel : of.channels) names.insert(channel.name);
    for (const IdChannel& channel : of.id_channels) names.insert(channel.name);
    return names;
  };
  const std::set<std::string> mine = names_of(image), others = names_of(other);
  std::vector<std::string> found;
  std::set_difference(mine.begin(), mine.end(), others.begin(), others.end(), std::back_inserter(found));
  return found;
}

/// Of the alpha of both.
std::size_t differing_alphas(const LayeredImage& picture, const LayeredImage& reference,
                             const PixelWindow& part) {
  const std::vector<float>*a = picture.find("A"), *b = reference.find("A");
  if (a == nullptr || b == nullptr) return 0;
  const std::vector<float> mine = cropped(*a, picture, part), others = cropped(*b, reference, part);
  return std::inner_product(mine.begin(), mine.end(), others.begin(), std::size_t{0}, std::plus<>(),
                            [](float x, float y) { return are_same(x, y) ? 0u : 1u; });
}

/// What R, G and B of `common`, which both have, do not say.
std::vector<std::string> warnings_of(const LayeredImage& picture, const LayeredImage& reference,
                                     const PixelWindow& common) {
  std::vector<std::string> warnings;
  if (picture.display_window() != reference.display_window()) {
    warnings.push_back(fmt::format("The display windows differ: {}, of the reference {}.",
                                   describe(picture.display_window()), describe(reference.display_window())));
  }
  if (picture.pixel_aspect != reference.pixel_aspect) {
    warnings.push_back(
        fmt::format("The shapes of the pixels differ: {} times as wide as high, of the reference {}.",
                    picture.pixel_aspect, reference.pixel_aspect));
  }
  if (!std::equal(picture.chromaticities.begin(), picture.chromaticities.end(),
                  reference.chromaticities.begin(), are_same)) {
    warnings.push_back(fmt::format(
        "R, G and B are of other colors in the two: the chromaticities are {}, of the reference {}.",
        fmt::join(picture.chromaticities, " "), fmt::join(reference.chromaticities, " ")));
  }
  if (!are_same(picture.white_luminance, reference.white_luminance)) {
    warnings.push_back(
        fmt::format("White is of another luminance in the two: {}, of the reference {} (0: not said).",
                    picture.white_luminance, reference.white_luminance));
  }
  if (picture.is_cube_map != reference.is_cube_map) {
    warnings.push_back(fmt::format("The {} is the six sides of a cube, the {} is not.",
                                   picture.is_cube_map ? "picture" : "reference",
                                   picture.is_cube_map ? "reference" : "picture"));
  }
  if (const std::size_t alphas = differing_alphas(picture, reference, common); alphas > 0)
    warnings.push_back(fmt::format("A, which is not compared, differs in {} of {} pixels.", alphas,
                                   common.width * common.height));
  if (const auto names = only_in(picture, reference); !names.empty())
    warnings.push_back(fmt::format("Only the picture has {}.", fmt::join(names, ", ")));
  if (const auto names = only_in(reference, picture); !names.empty())
    warnings.push_back(fmt::format("Only the reference has {}.", fmt::join(names, ", ")));
  return warnings;
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
std::vector<bool> finite_pixels(const Channels& a, const Channels& b) {
  std::vector<bool> finite(a[0].size());
  for (std::size_t i = 0; i < finite.size(); ++i)
    finite[i] = is_finite(pixel(a, i)) && is_finite(pixel(b, i));
  return finite;
}

/// What a display shows; black where not finite, so that FLIP's filters do not spread it.
DisplayedPicture displayed(const Channels& channels, const std::vector<bool>& finite,
                           const Comparison& found) {
  DisplayedPicture shown{.width = found.width, .height = found.height, .rgb = {}};
  for (std::size_t c = 0; c < 3; ++c) {
    shown.rgb[c].resize(finite.size());
    for (std::size_t i = 0; i < finite.size(); ++i) {
      shown.rgb[c][i] = finite[i] ? tone_mapped(channels[c][i]) : 0;
    }
  }
  return shown;
}

void add_flip(const Channels& a, const Channels& b, const std::vector<bool>& finite, Comparison& found) {
  found.flip_map = flip(displayed(a, finite, found), displayed(b, finite, found));
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
  const auto difference = [&](std::size_t i) {
    const double squares = squared_difference(pixel(a, i), pixel(b, i));
    return std::isfinite(squares) ? squares : std::numeric_limits<double>::infinity();
  };
  const std::size_t kept = std::min(kWorstPixels, differing.size());
  std::partial_sort(differing.begin(), differing.begin() + static_cast<std::ptrdiff_t>(kept), differing.end(),
                    [&](std::size_t i, std::size_t j) {
                      const double di = difference(i);
                      const double dj = difference(j);
                      return di != dj ? di > dj : i < j;
                    });
  for (std::size_t k = 0; k < kept; ++k) {
    const std::size_t i = differing[k];
    const auto x = static_cast<std::int64_t>(i % found.width), y = static_cast<std::int64_t>(i / found.width);
    found.worst.push_back({found.left + x, found.top + y, pixel(a, i), pixel(b, i)});
  }
}

}  // namespace

Comparison compare(const LayeredImage& picture, const LayeredImage& reference) {
  const PixelWindow common = checked_window(picture, reference);
  const Channels a = channels_of(picture, common, "picture");
  const Channels b = channels_of(reference, common, "reference");
  const std::size_t count = common.width * common.height;
  Comparison found{.width = common.width, .height = common.height, .left = common.left, .top = common.top};
  found.only_in_picture = picture.width * picture.height - count;
  found.only_in_reference = reference.width * reference.height - count;
  found.warnings = warnings_of(picture, reference, common);
  const std::vector<bool> finite = finite_pixels(a, b);
  found.not_finite = static_cast<std::size_t>(std::count(finite.begin(), finite.end(), false));
  if (found.not_finite == count) throw ComparisonError("No pixel is finite in both pictures.");
  double squares = 0;
  double relative = 0;
  std::vector<std::size_t> differing;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<float, 3> p = pixel(a, i);
    const std::array<float, 3> r = pixel(b, i);
    if (!std::equal(p.begin(), p.end(), r.begin(), are_same)) differing.push_back(i);
    if (!finite[i]) continue;
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
  add_flip(a, b, finite, found);
  add_worst(a, b, std::move(differing), found);
  return found;
}

}  // namespace stbvh::harness
