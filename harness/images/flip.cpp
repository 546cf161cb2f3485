#include "harness/images/flip.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace stbvh::harness {
namespace {

using Color = std::array<double, 3>;

/// Numbers of all pixels.
struct Plane {
  std::size_t width;
  std::size_t height;
  std::vector<double> values;
};
using Planes = std::array<Plane, 3>;

// The paper's constants, with its names.
constexpr double kQc = 0.7;
constexpr double kPc = 0.4;
constexpr double kPt = 0.95;
constexpr double kQf = 0.5;
constexpr double kW = 0.082;  // degrees that an edge is wide

/// sRGB's primaries in CIE XYZ (IEC 61966-2-1); white is the sum of each row.
constexpr std::array<Color, 3> kXyzFromRgb{{{0.4124564, 0.3575761, 0.1804375},
                                            {0.2126729, 0.7151522, 0.0721750},
                                            {0.0193339, 0.1191920, 0.9503041}}};

double dot(const Color& a, const Color& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// XYZ over that of white.
Color relative_xyz(const Color& rgb) {
  Color xyz{};
  for (std::size_t i = 0; i < 3; ++i) xyz[i] = dot(kXyzFromRgb[i], rgb) / dot(kXyzFromRgb[i], {1, 1, 1});
  return xyz;
}

Color rgb_from_relative_xyz(const Color& relative) {
  // Cramer's rule, so that the two directions cannot drift apart.
  const auto cross = [](const Color& a, const Color& b) -> Color {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto& m = kXyzFromRgb;
  const double determinant = dot(m[0], cross(m[1], m[2]));
  const std::array<Color, 3> cofactors{cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])};
  Color rgb{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      rgb[i] += cofactors[k][i] * relative[k] * dot(m[k], {1, 1, 1}) / determinant;
    }
  }
  return rgb;
}

/// The opponent space in which the eye's contrast sensitivity is modelled (linearised CIELAB).
Color ycxcz(const Color& rgb) {
  const Color r = relative_xyz(rgb);
  return {116 * r[1] - 16, 500 * (r[0] - r[1]), 200 * (r[1] - r[2])};
}

Color rgb_from_ycxcz(const Color& c) {
  const double y = (c[0] + 16) / 116;
  return rgb_from_relative_xyz({y + c[1] / 500, y, y - c[2] / 200});
}

/// CIELAB with Hunt's effect: colours count for less where it is dark.
Color hunt_lab(const Color& rgb) {
  constexpr double kDelta = 6.0 / 29;
  Color f = relative_xyz(rgb);
  for (double& v : f) v = v > kDelta * kDelta * kDelta ? std::cbrt(v) : v / (3 * kDelta * kDelta) + 4.0 / 29;
  const double lightness = 116 * f[1] - 16;
  return {lightness, 0.01 * lightness * 500 * (f[0] - f[1]), 0.01 * lightness * 200 * (f[1] - f[2])};
}

double hyab(const Color& a, const Color& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

/// Difference of colours, 0 to 1: what is small is spread over most of the range.
double color_difference(const Color& lab_a, const Color& lab_b) {
  static const double kLargest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kQc);
  const double error = std::pow(hyab(lab_a, lab_b), kQc);
  const double knee = kPc * kLargest;
  if (error < knee) return kPt / knee * error;
  return kPt + (error - knee) / (kLargest - knee) * (1 - kPt);
}

/// A row of weights, the middle one at the pixel itself.
using Kernel = std::vector<double>;

/// f at -radius to radius.
template <class Function>
Kernel sampled(int radius, Function f) {
  Kernel kernel;
  for (int i = -radius; i <= radius; ++i) kernel.push_back(f(static_cast<double>(i)));
  return kernel;
}

double sum(const Kernel& kernel) {
  double total = 0;
  for (double weight : kernel) total += weight;
  return total;
}

Kernel scaled(Kernel kernel, double factor) {
  for (double& weight : kernel) weight *= factor;
  return kernel;
}

/// Positive weights sum up to 1, negative ones to -1.
Kernel balanced(Kernel kernel) {
  double positive = 0;
  double negative = 0;
  for (double weight : kernel) (weight > 0 ? positive : negative) += weight;
  for (double& weight : kernel) weight /= weight > 0 ? positive : -negative;
  return kernel;
}

/// Pixels `stride` apart, `count` of them, from `in` to `out`; what lies outside is like the border.
void convolve_line(const double* in, double* out, std::size_t count, std::size_t stride,
                   const Kernel& kernel) {
  const auto radius = static_cast<std::ptrdiff_t>(kernel.size() / 2);
  const auto last = static_cast<std::ptrdiff_t>(count) - 1;
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    double total = 0;
    for (std::ptrdiff_t k = -radius; k <= radius; ++k) {
      const auto at = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i + k, 0, last));
      total += kernel[static_cast<std::size_t>(k + radius)] * in[at * stride];
    }
    out[static_cast<std::size_t>(i) * stride] = total;
  }
}

Plane convolve(const Plane& plane, const Kernel& along_rows, const Kernel& along_columns) {
  Plane rows = plane;
  for (std::size_t y = 0; y < plane.height; ++y) {
    const std::size_t first = y * plane.width;
    convolve_line(&plane.values[first], &rows.values[first], plane.width, 1, along_rows);
  }
  Plane both = rows;
  for (std::size_t x = 0; x < plane.width; ++x) {
    convolve_line(&rows.values[x], &both.values[x], plane.height, plane.width, along_columns);
  }
  return both;
}

/// The eye's contrast sensitivity in a channel as a sum of two Gaussians: a sqrt(pi / b) exp(-pi^2 d^2 / b),
/// d in degrees.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivities{
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

/// Blurred as the eye does.
Plane filtered(const Plane& plane, const Sensitivity& s, double pixels_per_degree) {
  constexpr double kPi = std::numbers::pi;
  constexpr double kWidest = 0.04;  // the largest b
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * pixels_per_degree));
  Plane total{plane.width, plane.height, std::vector<double>(plane.values.size(), 0.0)};
  double weight = 0;
  for (const auto& [a, b] : {std::pair(s.a1, s.b1), std::pair(s.a2, s.b2)}) {
    if (a == 0) continue;
    const Kernel bell = sampled(radius, [pixels_per_degree, b = b](double pixels) {
      const double d = pixels / pixels_per_degree;
      return std::exp(-kPi * kPi * d * d / b);
    });
    const double height = a * std::sqrt(kPi / b);
    const Plane part = convolve(plane, bell, scaled(bell, height));
    for (std::size_t i = 0; i < total.values.size(); ++i) total.values[i] += part.values[i];
    weight += height * sum(bell) * sum(bell);
  }
  for (double& v : total.values) v /= weight;
  return total;
}

Color at(const Planes& planes, std::size_t i) {
  return {planes[0].values[i], planes[1].values[i], planes[2].values[i]};
}

Planes to_ycxcz(const DisplayedPicture& picture) {
  const std::size_t pixels = picture.width * picture.height;
  const Plane empty{picture.width, picture.height, std::vector<double>(pixels)};
  Planes planes{empty, empty, empty};
  for (std::size_t i = 0; i < pixels; ++i) {
    const Color c = ycxcz({picture.rgb[0][i], picture.rgb[1][i], picture.rgb[2][i]});
    for (std::size_t k = 0; k < 3; ++k) planes[k].values[i] = c[k];
  }
  return planes;
}

/// What the eye makes of the colours of a picture, in hunt_lab.
std::vector<Color> seen_colors(const Planes& opponent, double pixels_per_degree) {
  Planes blurred = opponent;
  for (std::size_t k = 0; k < 3; ++k)
    blurred[k] = filtered(opponent[k], kSensitivities[k], pixels_per_degree);
  std::vector<Color> colors(opponent[0].values.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    Color rgb = rgb_from_ycxcz(at(blurred, i));
    for (double& v : rgb) v = std::clamp(v, 0.0, 1.0);
    colors[i] = hunt_lab(rgb);
  }
  return colors;
}

/// How much of an edge, and of a point, there is at each pixel.
struct Features {
  std::vector<double> edges;
  std::vector<double> points;
};

Features features(const Plane& y, double pixels_per_degree) {
  const double sigma = 0.5 * kW * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto bell = [&](double x) { return std::exp(-x * x / (2 * sigma * sigma)); };
  Kernel smooth = sampled(radius, bell);
  smooth = scaled(smooth, 1 / sum(smooth));
  const Kernel edge = balanced(sampled(radius, [&](double x) { return -x * bell(x); }));
  const Kernel point =
      balanced(sampled(radius, [&](double x) { return (x * x / (sigma * sigma) - 1) * bell(x); }));
  Plane lightness = y;
  for (double& v : lightness.values) v = (v + 16) / 116;
  const auto magnitude = [&](const Kernel& kernel) {
    std::vector<double> found = convolve(lightness, kernel, smooth).values;
    const Plane down = convolve(lightness, smooth, kernel);
    for (std::size_t i = 0; i < found.size(); ++i) found[i] = std::hypot(found[i], down.values[i]);
    return found;
  };
  return {magnitude(edge), magnitude(point)};
}

}  // namespace

std::vector<float> flip(const DisplayedPicture& a, const DisplayedPicture& b, double pixels_per_degree) {
  const std::size_t pixels = a.width * a.height;
  if (pixels == 0 || a.width != b.width || a.height != b.height) {
    throw std::invalid_argument("FLIP compares two pictures of the same size.");
  }
  const Planes opponent_a = to_ycxcz(a);
  const Planes opponent_b = to_ycxcz(b);
  const std::vector<Color> seen_a = seen_colors(opponent_a, pixels_per_degree);
  const std::vector<Color> seen_b = seen_colors(opponent_b, pixels_per_degree);
  const Features features_a = features(opponent_a[0], pixels_per_degree);
  const Features features_b = features(opponent_b[0], pixels_per_degree);
  std::vector<float> found(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    const double feature = std::max(std::abs(features_a.edges[i] - features_b.edges[i]),
                                    std::abs(features_a.points[i] - features_b.points[i]));
    const double feature_difference = std::pow(feature / std::numbers::sqrt2, kQf);
    found[i] = static_cast<float>(std::pow(color_difference(seen_a[i], seen_b[i]), 1 - feature_difference));
  }
  return found;
}

}  // namespace stbvh::harness
