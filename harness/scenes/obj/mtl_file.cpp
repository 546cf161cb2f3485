#include "harness/scenes/obj/mtl_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "harness/files/input_file.h"
#include "harness/files/numbers.h"
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
    std::string_view keyword, arguments;
    while (lines_.next(keyword, arguments)) {
      check_cancelled();
      if (keyword == "newmtl") {
        finish();
        name_ = arguments;
      } else if (!read(keyword, arguments)) {
        const std::string line = fmt::format("{} {}", keyword, arguments.substr(0, kMostShown));
        bad_lines_.add(fmt::format("\"{}\" in line {}", without_trailing_blanks(line), lines_.number()));
      }
    }
    finish();
    if (bad_lines_.count() > 0) {
      warn(fmt::format("{}: left out, as they are not finite numbers, or no RGB: {} value{}: {}",
                       file_.string(), bad_lines_.count(), bad_lines_.count() == 1 ? "" : "s",
                       bad_lines_.text()));
    }
    return std::move(materials_);
  }

 private:
  static constexpr std::size_t kMostShown = 80;  // characters of a line

  /// False where no value is read from a line that has one.
  bool read(std::string_view keyword, std::string_view arguments) {
    if (keyword == "Kd") return read_color(arguments, diffuse_);
    if (keyword == "Ks") return read_color(arguments, specular_);
    if (keyword == "Ke") return read_color(arguments, emission_);
    if (keyword == "Ns") return read_number(take_word(arguments), exponent_);
    if (keyword == "d") return read_opacity(arguments);
    if (keyword == "Tr") return read_transparency(arguments);
    if (keyword.starts_with("map_") || is_texture(keyword)) warn(kTexturesLeftOut);
    return true;
  }

  static bool is_texture(std::string_view keyword) {
    static constexpr std::array<std::string_view, 5> kTextures{"bump", "disp", "decal", "refl", "norm"};
    return std::find(kTextures.begin(), kTextures.end(), keyword) != kTextures.end();
  }

  bool read_opacity(std::string_view arguments) const {
    std::string_view word = take_word(arguments);
    if (word == "-halo") word = take_word(arguments);  // more opaque towards the outline
    float opacity = 1;
    if (!read_number(word, opacity)) return false;
    if (opacity < 1) warn(kReadAsOpaque);
    return true;
  }

  bool read_transparency(std::string_view arguments) const {
    float transparency = 0;
    if (!read_number(take_word(arguments), transparency)) return false;
    if (transparency > 0) warn(kReadAsOpaque);
    return true;
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
  static bool read_color(std::string_view arguments, Vec3f& color) {
    Vec3f c;
    if (!read_number(take_word(arguments), c.x)) return false;
    c.y = c.z = c.x;
    const std::string_view second = take_word(arguments);
    if (!second.empty() && !(read_number(second, c.y) && read_number(take_word(arguments), c.z)))
      return false;
    color = c;
    return true;
  }

  static bool read_number(std::string_view word, float& number) {
    const auto value = to_number<float>(word);
    if (!value || !std::isfinite(*value)) return false;
    number = *value;
    return true;
  }

  void warn(const std::string& sentence) const {
    if (warn_) warn_(sentence);
  }

  const std::filesystem::path& file_;
  ObjLines lines_;
  const SceneWarning& warn_;
  std::map<std::string, Material> materials_;
  std::optional<std::string> name_;
  Vec3f diffuse_{Material{}.color}, specular_{kBlack}, emission_{kBlack};
  float exponent_ = kDefaultExponent;
  NameList bad_lines_;
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

void warn_of_undefined(const NameList& materials, const std::filesystem::path& file,
                       const SceneWarning& warn) {
  if (materials.count() == 0) return;
  warn(fmt::format("{}: {} material{} not defined, and read as diffuse grey: {}", file.string(),
                   materials.count(), materials.count() == 1 ? " is" : "s are", materials.text()));
}

std::map<std::string, Material> read_mtl_file(const std::filesystem::path& file, const SceneWarning& warn) {
  try {
    return MtlParser(file, read_text_file(file, kMaxSceneTextBytes), warn).run();
  } catch (const InputFileError& error) {
    throw SceneFileError(fmt::format("{}: it {}", file.string(), error.what()));
  }
}

}  // namespace stbvh::harness
