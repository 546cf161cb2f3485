#include "harness/scenes/embree_xml/material.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "harness/files/numbers.h"
#include "harness/files/text.h"
#include "harness/scenes/embree_xml/document.h"
#include "harness/scenes/obj/mtl_file.h"

namespace stbvh::harness::embree_xml {
namespace {

/// The parameters of one material, by name.
class Parameters {
 public:
  Parameters(pugi::xml_node element, const Warn& warn) {
    for (const pugi::xml_node entry : element.children()) {
      if (entry.type() != pugi::node_element) continue;
      if (std::string_view(entry.name()).starts_with("texture")) {
        warn(kTexturesLeftOut);
        continue;
      }
      const std::string text = text_of(entry);
      std::string_view rest = text;
      std::vector<float>& values = values_[entry.attribute("name").value()];
      values.clear();
      for (auto word = take_word(rest); !word.empty(); word = take_word(rest)) {
        const auto value = to_number<float>(word);
        if (!value || !std::isfinite(*value))
          fail(entry, "the material parameter \"{}\" is not a number", entry.attribute("name").value());
        values.push_back(*value);
      }
    }
  }

  float number(const std::string& name, float otherwise) const {
    const auto found = values_.find(name);
    return found == values_.end() || found->second.empty() ? otherwise : found->second.front();
  }

  Vec3f color(const std::string& name, Vec3f otherwise) const {
    const auto found = values_.find(name);
    if (found == values_.end() || found->second.size() < 3) return otherwise;
    return {found->second[0], found->second[1], found->second[2]};
  }

 private:
  std::map<std::string, std::vector<float>> values_;
};

constexpr Vec3f kWhite{1, 1, 1};
constexpr Vec3f kBlack{0, 0, 0};

Material read_obj(const Parameters& parameters, bool is_lower_case, const Warn& warn) {
  if (parameters.number("d", 1) != 1) warn(kReadAsOpaque);
  return obj_material(parameters.color(is_lower_case ? "kd" : "Kd", kWhite),
                      parameters.color(is_lower_case ? "ks" : "Ks", kBlack),
                      parameters.number(is_lower_case ? "ns" : "Ns", 10));
}

Material make(Material::Kind kind, Vec3f color, float index = Material{}.index_of_refraction,
              float roughness = Material{}.roughness) {
  Material material;
  material.kind = kind;
  material.color = clamped_reflectance(color);
  material.index_of_refraction = index;
  material.roughness = std::clamp(roughness, 0.0f, 1.0f);
  return material;
}

/// A metal has no diffuse base: a rough one becomes the sharp mirror that it is nearest to.
Material read_metal(const Parameters& parameters) {
  return make(Material::Kind::kMirror, parameters.color("reflectance", kWhite));
}

Material material_of_kind(const std::string& kind, const Parameters& p, const Warn& warn) {
  using Kind = Material::Kind;
  if (kind == "OBJ") return read_obj(p, false, warn);
  if (kind == "OBJMaterial") return read_obj(p, true, warn);
  if (kind == "Matte" || kind == "MatteMaterial" || kind == "Velvet")
    return make(Kind::kDiffuse, p.color("reflectance", kWhite));
  if (kind == "Mirror") return make(Kind::kMirror, p.color("reflectance", kWhite));
  if (kind == "Metal" || kind == "ReflectiveMetal") return read_metal(p);
  if (kind == "Dielectric" || kind == "Glass")
    return make(Kind::kGlass, p.color("transmission", kWhite), p.number("etaInside", p.number("eta", 1.4f)));
  // One sheet stands for both sides of a pane, so light leaves it in the direction in which it came.
  if (kind == "ThinDielectric" || kind == "ThinGlass")
    return make(Kind::kGlass, p.color("transmission", kWhite), 1.0f);
  if (kind == "Plastic")
    return make(Kind::kGlossy, p.color("pigmentColor", kWhite), p.number("eta", 1.4f),
                p.number("roughness", 0.01f));
  if (kind == "MetallicPaint")
    return make(Kind::kGlossy, p.color("shadeColor", kWhite), p.number("eta", 1.4f), 0);
  warn(fmt::format("Materials of the kind \"{}\" are unknown and read as diffuse grey.", kind));
  return {};
}

}  // namespace

Material MaterialReader::read(pugi::xml_node material) {
  if (!material) return {};
  const std::string id = material.attribute("id").value();
  if (const auto known = by_id_.find(id); !id.empty() && known != by_id_.end()) return known->second;
  const pugi::xml_node element = material.child("parameters");
  std::string kind = text_of(material.child("code"));
  std::erase_if(kind, [](unsigned char c) { return c == '"' || std::isspace(c); });
  if (!element && kind.empty()) {
    if (undefined_ids_.insert(id).second) undefined_.add(fmt::format("\"{}\"", id));
    return {};
  }
  const Parameters parameters(element, warn_);
  Material result = material_of_kind(kind, parameters, warn_);
  // Not Embree's, whose tools overlook it: so that what convert writes keeps its lamps.
  const Vec3f emission = parameters.color("emission", kBlack);
  result.emission = {std::max(emission.x, 0.0f), std::max(emission.y, 0.0f), std::max(emission.z, 0.0f)};
  if (!id.empty()) by_id_[id] = result;
  return result;
}

void MaterialReader::tell_undefined(const std::filesystem::path& file) const {
  warn_of_undefined(undefined_, file, warn_);
}

void MaterialReader::define(const std::string& id, pugi::xml_node material) {
  by_id_[id] = read(material);
}

}  // namespace stbvh::harness::embree_xml
