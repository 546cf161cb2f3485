#include "harness/scenes/gltf/clip.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "harness/scenes/gltf/accessor.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/gltf/transform.h"

namespace stbvh::harness::gltf {
namespace {

std::string list_of_clips(const tinygltf::Model& model) {
  std::string list;
  for (std::size_t i = 0; i < model.animations.size(); ++i) {
    list += fmt::format("{}{} '{}'", i == 0 ? "" : ", ", i, model.animations[i].name);
  }
  return list;
}

const tinygltf::Animation& find_animation(const tinygltf::Model& model, const std::string& name_or_index) {
  if (name_or_index.empty()) return model.animations.front();
  for (const tinygltf::Animation& animation : model.animations) {
    if (animation.name == name_or_index) return animation;
  }
  std::size_t index = 0;
  const char* const end = name_or_index.data() + name_or_index.size();
  const auto [stopped, error] = std::from_chars(name_or_index.data(), end, index);
  if (error == std::errc() && stopped == end && index < model.animations.size())
    return model.animations[index];
  if (model.animations.empty()) fail("it has no clip '{}', for it has no animation at all", name_or_index);
  fail("it has no clip '{}'; its clips are {}", name_or_index, list_of_clips(model));
}

std::optional<AnimatedProperty> property_of(const std::string& path) {
  if (path == "translation") return AnimatedProperty::kTranslation;
  if (path == "rotation") return AnimatedProperty::kRotation;
  if (path == "scale") return AnimatedProperty::kScale;
  if (path == "weights") return AnimatedProperty::kWeights;
  return std::nullopt;
}

Interpolation interpolation_of(const std::string& name) {
  if (name == "LINEAR") return Interpolation::kLinear;
  if (name == "STEP") return Interpolation::kStep;
  if (name == "CUBICSPLINE") return Interpolation::kCubicSpline;
  fail("an animation has the unknown interpolation '{}'", name);
}

std::vector<double> read_key_times(const tinygltf::Model& model, int accessor) {
  std::vector<double> times = read_numbers(model, accessor, TINYGLTF_TYPE_SCALAR, "animation times");
  if (times.empty()) fail("accessor {} (animation times) has no keys", accessor);
  const bool finite = std::all_of(times.begin(), times.end(), [](double t) { return std::isfinite(t); });
  if (!finite || !std::is_sorted(times.begin(), times.end())) {
    fail("accessor {} (animation times) is not in increasing order", accessor);
  }
  return times;
}

Channel read_channel(const tinygltf::Model& model, const tinygltf::Animation& animation,
                     const tinygltf::AnimationChannel& source, AnimatedProperty property) {
  if (source.sampler < 0 || static_cast<std::size_t>(source.sampler) >= animation.samplers.size()) {
    fail("an animation refers to its missing sampler {}", source.sampler);
  }
  if (static_cast<std::size_t>(source.target_node) >= model.nodes.size()) {
    fail("an animation refers to the missing node {}", source.target_node);
  }
  Channel channel;
  channel.node = static_cast<std::size_t>(source.target_node);
  channel.property = property;
  if (property != AnimatedProperty::kWeights && !model.nodes[channel.node].matrix.empty()) {
    fail("node {} is animated, but has a matrix instead of translation, rotation and scale", channel.node);
  }
  const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(source.sampler)];
  channel.interpolation = interpolation_of(sampler.interpolation);
  channel.times = read_key_times(model, sampler.input);
  const int type = property == AnimatedProperty::kWeights    ? TINYGLTF_TYPE_SCALAR
                   : property == AnimatedProperty::kRotation ? TINYGLTF_TYPE_VEC4
                                                             : TINYGLTF_TYPE_VEC3;
  channel.values = read_numbers(model, sampler.output, type, "animation values");
  const std::size_t rows =
      channel.times.size() * (channel.interpolation == Interpolation::kCubicSpline ? 3 : 1);
  channel.width = property == AnimatedProperty::kWeights    ? channel.values.size() / rows
                  : property == AnimatedProperty::kRotation ? 4
                                                            : 3;
  if (channel.values.size() != channel.width * rows) {
    fail("accessor {} (animation values) does not have as many elements as its {} keys need", sampler.output,
         channel.times.size());
  }
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
    const Quaternion q = slerp({from[0], from[1], from[2], from[3]}, {to[0], to[1], to[2], to[3]}, f);
    std::copy(q.begin(), q.end(), result.begin());
    return;
  }
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = (1 - f) * from[i] + f * to[i];
}

}  // namespace

void Channel::evaluate(double time, std::span<double> result) const {
  const bool cubic = interpolation == Interpolation::kCubicSpline;
  const std::size_t row = cubic ? 3 * width : width;
  const std::span<const double> all(values);
  const auto behind = std::upper_bound(times.begin(), times.end(), time);
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
    evaluate_linear(from, to, f, property == AnimatedProperty::kRotation, result);
  }
}

std::optional<Clip> read_clip(const tinygltf::Model& model, const std::string& name_or_index) {
  if (name_or_index.empty() && model.animations.empty()) return std::nullopt;
  const tinygltf::Animation& animation = find_animation(model, name_or_index);
  Clip clip;
  for (const tinygltf::AnimationChannel& source : animation.channels) {
    const std::optional<AnimatedProperty> property = property_of(source.target_path);
    // The specification lets loaders skip what has no target node or targets something of an extension.
    if (source.target_node < 0 || !property) continue;
    clip.channels.push_back(read_channel(model, animation, source, *property));
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
