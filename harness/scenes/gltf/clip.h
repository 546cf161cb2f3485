/// One animation of a glTF file, ready to be evaluated at any time.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "harness/scenes/gltf/model.h"

namespace stbvh::harness::gltf {

enum class AnimatedProperty {
  kTranslation,
  kRotation,
  kScale,
  kWeights,     ///< all of them
  kWeight,      ///< one
  kVisibility,  ///< 0: not there, and all below it neither
};
enum class Interpolation { kStep, kLinear, kCubicSpline };

/// Where something jumps, it has two values at one time.
enum class Side { kBefore, kAfter };

/// What a channel moves.
struct Target {
  std::size_t node = 0;
  AnimatedProperty property = AnimatedProperty::kTranslation;
  std::size_t weight = 0;  ///< which, of kWeight
  Model::Index mesh = {};  ///< of weights, instead of `node`: all nodes with it and no weights of their own
};

/// Finds the nodes that targets are about.
class TargetNodes {
 public:
  explicit TargetNodes(const Model& model);
  /// Those of `target`, which must outlive them.
  std::span<const std::size_t> of(const Target& target) const;

 private:
  std::vector<std::vector<std::size_t>> nodes_of_meshes_;  // that have no weights of their own
};

/// How one property of one node moves: `width` numbers at each key (three times as many for cubic splines:
/// in-tangent, value, out-tangent).
struct Channel {
  Target target;
  Interpolation interpolation = Interpolation::kLinear;
  std::size_t width = 0;
  std::vector<double> times;  ///< seconds, not decreasing, at least one
  std::vector<double> values;

  /// Writes `width` numbers; before the first and behind the last key, the property keeps that key's value.
  void evaluate(double time, Side side, std::span<double> result) const;
};

struct Clip {
  std::vector<Channel> channels;
  double begin = 0, end = 0;  ///< first and last key of all channels, in seconds
};

/// The channels of an animation, before their keys are read.
struct ClipSource {
  struct Channel {
    Target target;
    Model::Sampler sampler;
  };
  std::vector<Channel> channels;
  std::map<std::string, std::size_t> left_out;  ///< channels that are not read, by what they would move
  std::size_t others = 0;                       ///< animations besides the first, where none is asked for
};

/// The animation whose name or, failing that, index is `name_or_index`; the first if that is empty.
/// Nothing if the file has no animation and none is asked for. Throws Problem.
std::optional<ClipSource> find_clip(const Model& model, const std::string& name_or_index);

/// All keys. Throws Problem.
Clip read_clip(const Model& model, const ClipSource& source);

}  // namespace stbvh::harness::gltf
