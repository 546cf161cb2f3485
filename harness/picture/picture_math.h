/// The little vector algebra and the random numbers that shading needs.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "stbvh/vec.h"

namespace stbvh::harness::picture {

inline Vec3f operator+(Vec3f a, Vec3f b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3f operator-(Vec3f a, Vec3f b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3f operator*(Vec3f a, Vec3f b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline Vec3f operator*(float s, Vec3f a) {
  return {s * a.x, s * a.y, s * a.z};
}

inline float dot(Vec3f a, Vec3f b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3f cross(Vec3f a, Vec3f b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Vec3f a) {
  return std::sqrt(dot(a, a));
}
inline Vec3f normalize(Vec3f a) {
  return (1.0f / length(a)) * a;
}
inline Vec3f mix(Vec3f a, Vec3f b, float f) {
  return (1.0f - f) * a + f * b;
}

/// Two unit vectors that make an orthonormal basis with the unit vector `w`.
struct Tangents {
  Vec3f u, v;
};
inline Tangents tangents_of(Vec3f w) {
  const Vec3f helper = std::abs(w.x) > 0.7f ? Vec3f{0, 1, 0} : Vec3f{1, 0, 0};
  const Vec3f u = normalize(cross(helper, w));
  return {u, cross(w, u)};
}

/// SplitMix64: one stream for each sample of each pixel, so that the order of work does not matter.
class SampleRandom {
 public:
  SampleRandom(std::uint64_t seed, std::uint64_t stream)
      : state_(mixed(seed) ^ mixed(stream + 0x51ED270B35AE4D1Bu)) {}

  /// Uniform in [0, 1).
  float next() {
    state_ += kGamma;
    return static_cast<float>(mixed(state_) >> 40) * 0x1p-24f;
  }

 private:
  static constexpr std::uint64_t kGamma = 0x9E3779B97F4A7C15u;
  static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

/// Unit vector around `normal` with density proportional to the cosine.
inline Vec3f cosine_direction(Vec3f normal, SampleRandom& random) {
  const float radius2 = random.next();
  const float angle = 2.0f * std::numbers::pi_v<float> * random.next();
  const float radius = std::sqrt(radius2);
  const Tangents t = tangents_of(normal);
  return normalize((radius * std::cos(angle)) * t.u + (radius * std::sin(angle)) * t.v +
                   std::sqrt(1.0f - radius2) * normal);
}

}  // namespace stbvh::harness::picture
