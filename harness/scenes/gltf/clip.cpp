#include "harness/scenes/gltf/clip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/gltf/accessor.h"
#include "harness/scenes/gltf/named.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/gltf/transform.h"

namespace stbvh::harness::gltf {
namespace {

std::optional<AnimatedProperty> property_of(std::string_view path) {
  if (path == "translation") return AnimatedProperty::kTranslation;
  if (path == "rotation") return AnimatedProperty::kRotation;
  if (path == "scale") return AnimatedProperty::kScale;
  if (path == "weights") return AnimatedProperty::kWeights;
  if (path == "extensions/KHR_node_visibility/visible") return AnimatedProperty::kVisibility;
  return std::nullopt;
}

/// Of a JSON pointer like "/nodes/3/weights/1" or "/meshes/2/weights"; nothing where it points to what is not
/// read.
std::optional<Target> target_of_pointer(std::string_view pointer) {
  constexpr std::string_view kNodes = "/nodes/", kMeshes = "/meshes/", kWeights = "weights/";
  const bool is_of_mesh = pointer.starts_with(kMeshes);
  if (!is_of_mesh && !pointer.starts_with(kNodes)) return std::nullopt;
  pointer.remove_prefix((is_of_mesh ? kMeshes : kNodes).size());
  const std::size_t slash = std::min(pointer.find('/'), pointer.size());
  const auto index = parse_index(pointer.substr(0, slash));
  if (!index || slash == pointer.size()) return std::nullopt;
  Target target;
  if (is_of_mesh) {
    target.mesh = *index;
  } else {
    target.node = *index;
  }
  const std::string_view path = pointer.substr(slash + 1);
  if (path.starts_with(kWeights)) {
    const auto weight = parse_index(path.substr(kWeights.size()));
    if (!weight) return std::nullopt;
    target.property = AnimatedProperty::kWeight;
    target.weight = *weight;
    return target;
  }
  const auto property = property_of(path);
  if (!property || (is_of_mesh && property != AnimatedProperty::kWeights)) return std::nullopt;
  target.property = *property;
  return target;
}

std::optional<Target> target_of(const Model::Channel& channel) {
  if (channel.path == "pointer") return target_of_pointer(channel.pointer);
  const auto property = property_of(channel.path);
  if (!channel.node || !property) return std::nullopt;
  return Target{*channel.node, *property};
}

/// What a channel that is not read would move, the same for all parts of a kind:
/// "/materials/*/emissiveFactor".
std::string kind_of_target(const Model::Channel& channel) {
  if (channel.path != "pointer") return channel.path;
  std::string kind;
  for (const char c : channel.pointer) {
    const bool is_digit = c >= '0' && c <= '9';
    const bool is_in_number = is_digit && (kind.ends_with('/') || kind.ends_with('*'));
    if (!is_in_number) {
      kind += c;
    } else if (!kind.ends_with('*')) {
      kind += '*';
    }
  }
  return kind;
}

std::size_t target_count(const Model& model, const Target& target) {
  return target.mesh ? model.meshes[*target.mesh].target_count : target_count(model, target.node);
}

void check_weights(const Model& model, const Target& target) {
  const std::string who =
      target.mesh ? fmt::format("mesh {}", *target.mesh) : fmt::format("node {}", target.node);
  const std::size_t count = target_count(model, target);
  if (count == 0) fail("the weights of {} are animated, but it has no morph targets", who);
  if (target.property == AnimatedProperty::kWeight && target.weight >= count)
    fail("weight {} of {} is animated, but it has only {} morph targets", target.weight, who, count);
}

void check_target(const Model& model, const Target& target) {
  if (target.mesh && *target.mesh >= model.meshes.size())
    fail("an animation refers to the missing mesh {}", *target.mesh);
  if (target.node >= model.nodes.size()) fail("an animation refers to the missing node {}", target.node);
  const bool moves_node = target.property == AnimatedProperty::kTranslation ||
                          target.property == AnimatedProperty::kRotation ||
                          target.property == AnimatedProperty::kScale;
  if (moves_node && model.nodes[target.node].matrix)
    fail("node {} is animated, but has a matrix instead of translation, rotation and scale", target.node);
  if (target.property == AnimatedProperty::kWeights || target.property == AnimatedProperty::kWeight)
    check_weights(model, target);
}

/// The type of a key's value, and how many numbers a key has.
struct ValueShape {
  ElementType type;
  std::size_t width;
};

ValueShape shape_of(const Model& model, const Target& target) {
  switch (target.property) {
    case AnimatedProperty::kTranslation:
    case AnimatedProperty::kScale:
      return {ElementType::kVec3, 3};
    case AnimatedProperty::kRotation:
      return {ElementType::kVec4, 4};
    case AnimatedProperty::kWeights:
      return {ElementType::kScalar, target_count(model, target)};
    default:
      return {ElementType::kScalar, 1};
  }
}

Interpolation interpolation_of(const std::string& name) {
  if (name == "LINEAR" || name.empty()) return Interpolation::kLinear;
  if (name == "STEP") return Interpolation::kStep;
  if (name == "CUBICSPLINE") return Interpolation::kCubicSpline;
  fail("an animation has the unknown interpolation '{}'", name);
}

std::vector<double> read_key_times(const Model& model, std::size_t accessor) {
  std::vector<double> times = read_numbers(model, accessor, ElementType::kScalar, "animation times");
  if (times.empty()) fail("accessor {} (animation times) has no keys", accessor);
  const bool finite = std::all_of(times.begin(), times.end(), [](double t) { return std::isfinite(t); });
  if (!finite || !std::is_sorted(times.begin(), times.end())) {
    fail("accessor {} (animation times) is not in increasing order", accessor);
  }
  return times;
}

Channel read_channel(const Model& model, const ClipSource::Channel& source) {
  const Model::Sampler& sampler = source.sampler;
  Channel channel;
  channel.target = source.target;
  channel.interpolation = interpolation_of(sampler.interpolation);
  const AnimatedProperty property = channel.target.property;
  if (property == AnimatedProperty::kVisibility && channel.interpolation != Interpolation::kStep)
    fail("the visibility of node {} is animated, but not in steps", channel.target.node);
  channel.times = read_key_times(model, sampler.input);
  const ValueShape shape = shape_of(model, channel.target);
  channel.width = shape.width;
  const std::size_t rows =
      channel.times.size() * (channel.interpolation == Interpolation::kCubicSpline ? 3 : 1);
  const Model::Accessor& output = accessor_at(model, sampler.output, "animation values");
  if (output.count * component_count(shape.type) != shape.width * rows) {
    fail("accessor {} (animation values) has {} elements, but its {} keys need {}", sampler.output,
         output.count, channel.times.size(), shape.width * rows / component_count(shape.type));
  }
  channel.values = read_numbers(model, sampler.output, shape.type, "animation values");
  return channel;
}

/// Cubic Hermite spline between two keys that are `duration` seconds apart, as in glTF's appendix C.
void evaluate_cubic(std::span<const double> from, std::span<const double> to, double f, double duration,
                    std::span<double> result) {
  const std::size_t width = result.size();
  const double f2 = f * f, f3 = f2 * f;
  for (std::size_t i = 0; i < width; ++i) {
    const double value0 = from[width + i], out_tangent0 = from[2 * width + i];
    const double in_tangent1 = to[i], value1 = to[width + i];
    result[i] = (2 * f3 - 3 * f2 + 1) * value0 + duration * (f3 - 2 * f2 + f) * out_tangent0 +
                (3 * f2 - 2 * f3) * value1 + duration * (f3 - f2) * in_tangent1;
  }
}

void evaluate_linear(std::span<const double> from, std::span<const double> to, double f, bool is_rotation,
                     std::span<double> result) {
  if (is_rotation) {
    const Quaternion q = slerp(to_quaternion(from), to_quaternion(to), f);
    std::ranges::copy(std::array{q.x, q.y, q.z, q.w}, result.begin());
    return;
  }
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = (1 - f) * from[i] + f * to[i];
}

}  // namespace

TargetNodes::TargetNodes(const Model& model) : nodes_of_meshes_(model.meshes.size()) {
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const Model::Node& node = model.nodes[i];
    if (node.mesh && *node.mesh < model.meshes.size() && node.weights.empty())
      nodes_of_meshes_[*node.mesh].push_back(i);
  }
}

std::span<const std::size_t> TargetNodes::of(const Target& target) const {
  if (target.mesh) return nodes_of_meshes_[*target.mesh];
  return {&target.node, 1};
}

void Channel::evaluate(double time, Side side, std::span<double> result) const {
  const bool cubic = interpolation == Interpolation::kCubicSpline;
  const std::size_t row = cubic ? 3 * width : width;
  const std::span<const double> all(values);
  const auto behind = side == Side::kAfter ? std::upper_bound(times.begin(), times.end(), time)
                                           : std::lower_bound(times.begin(), times.end(), time);
  const std::size_t next = static_cast<std::size_t>(behind - times.begin());
  if (next == 0 || next == times.size() || interpolation == Interpolation::kStep) {
    const std::size_t key = next == 0 ? 0 : next - 1;
    const auto value = all.subspan(key * row + (cubic ? width : 0), width);
    std::copy(value.begin(), value.end(), result.begin());
    return;
  }
  const double duration = times[next] - times[next - 1];
  const double f = (time - times[next - 1]) / duration;
  const auto from = all.subspan((next - 1) * row, row), to = all.subspan(next * row, row);
  if (cubic) {
    evaluate_cubic(from, to, f, duration, result);
  } else {
    evaluate_linear(from, to, f, target.property == AnimatedProperty::kRotation, result);
  }
}

std::optional<ClipSource> find_clip(const Model& model, const std::string& name_or_index) {
  if (name_or_index.empty() && model.animations.empty()) return std::nullopt;
  const Model::Animation& animation =
      name_or_index.empty() ? model.animations.front() : find_named(model.animations, name_or_index, "clip");
  ClipSource clip;
  if (name_or_index.empty()) clip.others = model.animations.size() - 1;
  for (const Model::Channel& channel : animation.channels) {
    const std::optional<Target> target = target_of(channel);
    // The specification lets readers skip what has no target, for an extension may give it one.
    if (!target) {
      ++clip.left_out[kind_of_target(channel)];
      continue;
    }
    if (channel.sampler >= animation.samplers.size())
      fail("an animation refers to its missing sampler {}", channel.sampler);
    check_target(model, *target);
    clip.channels.push_back({*target, animation.samplers[channel.sampler]});
  }
  return clip;
}

Clip read_clip(const Model& model, const ClipSource& source) {
  Clip clip;
  for (const ClipSource::Channel& channel : source.channels) {
    check_cancelled();
    clip.channels.push_back(read_channel(model, channel));
  }
  if (clip.channels.empty()) return clip;
  clip.begin = std::numeric_limits<double>::infinity();
  clip.end = -clip.begin;
  for (const Channel& channel : clip.channels) {
    clip.begin = std::min(clip.begin, channel.times.front());
    clip.end = std::max(clip.end, channel.times.back());
  }
  return clip;
}

}  // namespace stbvh::harness::gltf
