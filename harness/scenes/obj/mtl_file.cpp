#include "harness/scenes/obj/mtl_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "harness/files/input_file.h"
#include "harness/scenes/cancellation.h"
#include "harness/scenes/obj/obj_lines.h"

namespace stbvh::harness {
namespace {

constexpr Vec3f kBlack{0, 0, 0};
constexpr float kDefaultExponent = 10;

/// The index at which a smooth dielectric reflects `share` of the light from straight ahead (Fresnel).
float index_reflecting(float share) {
  const float root = std::sqrt(std::clamp(share, 0.0f, 0.9f));
  return (1 + root) / (1 - root);
}

/// Of a microfacet distribution as wide as Blinn's with this exponent (Walter et al. 2007, section 5.2).
float roughness_of(float exponent) {
  return std::clamp(std::sqrt(2 / (std::max(exponent, 0.0f) + 2)), 0.0f, 1.0f);
}

class MtlParser {
 public:
  MtlParser(const std::filesystem::path& file, std::string_view text, const SceneWarning& warn)
      : file_(file), lines_(text), warn_(warn) {}

  std::map<std::string, Material> run() {
    std::string_view line;
    while (lines_.next(line)) {
      check_cancelled();
      const std::string_view keyword = take_word(line);
      if (keyword == "newmtl") {
        finish();
        name_ = without_leading_blanks(line);
      } else {
        read(keyword, line);
      }
    }
    finish();
    return std::move(materials_);
  }

 private:
  void read(std::string_view keyword, std::string_view line) {
    if (keyword == "Kd") diffuse_ = color(line);
    if (keyword == "Ks") specular_ = color(line);
    if (keyword == "Ke") emission_ = color(line);
    if (keyword == "Ns") exponent_ = number(take_word(line));
    if (keyword == "d" && number(take_word(line)) < 1) warn(kReadAsOpaque);
    if (keyword == "Tr" && number(take_word(line)) > 0) warn(kReadAsOpaque);
    if (keyword.starts_with("map_")) warn(kTexturesLeftOut);
  }

  void finish() {
    if (name_) {
      Material& material = materials_[*name_];
      material = obj_material(diffuse_, specular_, exponent_);
      material.emission = {std::max(emission_.x, 0.0f), std::max(emission_.y, 0.0f),
                           std::max(emission_.z, 0.0f)};
    }
    diffuse_ = Material{}.color;
    specular_ = emission_ = kBlack;
    exponent_ = kDefaultExponent;
  }

  /// One number stands for all three.
  Vec3f color(std::string_view line) const {
    Vec3f c;
    c.x = number(take_word(line));
    const std::string_view second = take_word(line);
    if (second.empty()) return {c.x, c.x, c.x};
    c.y = number(second);
    c.z = number(take_word(line));
    return c;
  }

  float number(std::string_view word) const {
    float value = 0;
    const char* const last = word.data() + word.size();
    const auto [end, error] = std::from_chars(word.data(), last, value);
    if (word.empty() || error != std::errc() || end != last || !std::isfinite(value)) {
      throw SceneFileError(
          fmt::format("{}: line {}: \"{}\" is not a number", file_.string(), lines_.number(), word));
    }
    return value;
  }

  void warn(const char* sentence) const {
    if (warn_) warn_(sentence);
  }

  const std::filesystem::path& file_;
  ObjLines lines_;
  const SceneWarning& warn_;
  std::map<std::string, Material> materials_;
  std::optional<std::string> name_;
  Vec3f diffuse_{Material{}.color}, specular_{kBlack}, emission_{kBlack};
  float exponent_ = kDefaultExponent;
};

}  // namespace

Vec3f clamped_reflectance(Vec3f color) {
  const auto channel = [](float x) { return std::clamp(x, 0.0f, 1.0f); };
  return {channel(color.x), channel(color.y), channel(color.z)};
}

Material obj_material(Vec3f diffuse, Vec3f specular, float exponent) {
  Material material;
  material.color = clamped_reflectance(diffuse);
  const float largest = std::max({specular.x, specular.y, specular.z});
  if (largest <= 0) return material;
  material.kind = Material::Kind::kGlossy;
  material.index_of_refraction = index_reflecting(largest);
  material.roughness = roughness_of(exponent);
  return material;
}

std::map<std::string, Material> read_mtl_file(const std::filesystem::path& file, const SceneWarning& warn) {
  try {
    return MtlParser(file, read_text_file(file, kMaxSceneTextBytes), warn).run();
  } catch (const InputFileError& error) {
    throw SceneFileError(fmt::format("{}: it {}", file.string(), error.what()));
  }
}

}  // namespace stbvh::harness
