/// One animation of a glTF file, ready to be evaluated at any time.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stbvh::harness::gltf {

enum class AnimatedProperty { kTranslation, kRotation, kScale, kWeights };
enum class Interpolation { kStep, kLinear, kCubicSpline };

/// How one property of one node moves: `width` numbers at each key (three times as many for cubic splines:
/// in-tangent, value, out-tangent).
struct Channel {
  std::size_t node = 0;
  AnimatedProperty property = AnimatedProperty::kTranslation;
  Interpolation interpolation = Interpolation::kLinear;
  std::size_t width = 0;
  std::vector<double> times;  ///< seconds, not decreasing, at least one
  std::vector<double> values;

  /// Writes `width` numbers; before the first and behind the last key, the property keeps that key's value.
  void evaluate(double time, std::span<double> result) const;
};

struct Clip {
  std::vector<Channel> channels;
  double begin = 0, end = 0;  ///< first and last key of all channels, in seconds
};

/// The animation whose name or, failing that, index is `name_or_index`; the first if that is empty.
/// Nothing if the file has no animation and none is asked for. Throws Problem.
std::optional<Clip> read_clip(const tinygltf::Model& model, const std::string& name_or_index);

}  // namespace stbvh::harness::gltf
