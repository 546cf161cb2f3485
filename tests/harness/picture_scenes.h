/// Small scenes whose pictures are known, and numbers about pictures.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "harness/path_tracer/render.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/vec3.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// A mesh of `steps` steps whose vertex positions at step k are given by `place(p, k)`.
inline Mesh placed(const std::vector<Vec3>& points, std::vector<std::uint32_t> indices, std::size_t steps,
                   const std::function<Vec3(Vec3, std::size_t)>& place) {
  Mesh mesh;
  mesh.indices = std::move(indices);
  for (std::size_t k = 0; k < steps; ++k) {
    VertexBuffer& buffer = mesh.steps.emplace_back(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) buffer[i] = to_float(place(points[i], k));
  }
  return mesh;
}

inline Vec3 unmoved(Vec3 p, std::size_t) {
  return p;
}

/// A closed sphere of radius 1 around the origin, wound outwards.
inline Mesh sphere(std::size_t steps = 1, const std::function<Vec3(Vec3, std::size_t)>& place = unmoved) {
  constexpr std::uint32_t kRings = 16, kSides = 32;
  std::vector<Vec3> points{{0, 1, 0}, {0, -1, 0}};
  std::vector<std::uint32_t> indices;
  const auto at = [](std::uint32_t ring, std::uint32_t side) {
    return 2 + (ring - 1) * kSides + side % kSides;
  };
  for (std::uint32_t r = 1; r < kRings; ++r) {
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const double a = kPi * r / kRings, b = 2 * kPi * s / kSides;
      points.push_back({std::sin(a) * std::sin(b), std::cos(a), std::sin(a) * std::cos(b)});
    }
  }
  for (std::uint32_t s = 0; s < kSides; ++s) {
    for (std::uint32_t i : {0u, at(1, s), at(1, s + 1)}) indices.push_back(i);
    for (std::uint32_t i : {1u, at(kRings - 1, s + 1), at(kRings - 1, s)}) indices.push_back(i);
    for (std::uint32_t r = 1; r + 1 < kRings; ++r) {
      for (std::uint32_t i :
           {at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s), at(r + 1, s + 1), at(r, s + 1)})
        indices.push_back(i);
    }
  }
  return placed(points, indices, steps, place);
}

/// A square of half side `half` around the origin, in the plane y = 0, that faces up.
inline Mesh square(double half, std::size_t steps = 1,
                   const std::function<Vec3(Vec3, std::size_t)>& place = unmoved) {
  return placed({{-half, 0, -half}, {-half, 0, half}, {half, 0, half}, {half, 0, -half}}, {0, 1, 2, 0, 2, 3},
                steps, place);
}

inline Environment constant_environment(float radiance = 1) {
  return {.radiance = {radiance, radiance, radiance}, .width = 0, .height = 0, .pixels = {}};
}

inline Material white(float reflectance = 1) {
  Material material;
  material.color = {reflectance, reflectance, reflectance};
  return material;
}

/// The camera looks at a point of the plane y = 0 from above, narrowly.
inline Camera looking_down_at(Vec3f target) {
  return {.position = {target.x + 3, target.y + 4, target.z},
          .target = target,
          .up = {0, 1, 0},
          .vertical_fov_degrees = 0.1f};
}

inline Rendering rendered(const Scene& scene, const RenderSettings& settings,
                          std::string_view structure = "stbvh-direct") {
  return render(scene, *build_structure(structure, scene, 0), settings);
}

inline RenderSettings small(std::size_t side, std::size_t samples) {
  return {
      .width = side, .height = side, .samples_per_pixel = samples, .lens = {}, .shutter = {}, .threads = 2};
}

/// Mean over all pixels, with its standard error as the samples say.
struct Estimate {
  double mean = 0, error = 0;
};
inline Estimate estimate(const LayeredImage& image, char channel = 'R') {
  const std::vector<float>& values = *image.find(std::string(1, channel));
  const std::vector<float>& variances = *image.find(std::string("variance.") + channel);
  Estimate e;
  for (float v : values) e.mean += static_cast<double>(v);
  for (float v : variances) e.error += static_cast<double>(v);
  const auto n = static_cast<double>(values.size());
  return {e.mean / n, std::sqrt(e.error) / n};
}

inline std::size_t differing_pixels(const LayeredImage& a, const LayeredImage& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.width * a.height; ++i) {
    for (const char* name : {"R", "G", "B"}) {
      if ((*a.find(name))[i] == (*b.find(name))[i]) continue;
      ++count;
      break;
    }
  }
  return count;
}

}  // namespace stbvh::harness
