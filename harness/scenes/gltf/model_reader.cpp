#include "harness/scenes/gltf/model_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "harness/scenes/gltf/extensions.h"
#include "harness/scenes/gltf/json_object.h"
#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

constexpr std::array<std::pair<std::string_view, ElementType>, 7> kElementTypes = {
    {{"SCALAR", ElementType::kScalar},
     {"VEC2", ElementType::kVec2},
     {"VEC3", ElementType::kVec3},
     {"VEC4", ElementType::kVec4},
     {"MAT2", ElementType::kMat2},
     {"MAT3", ElementType::kMat3},
     {"MAT4", ElementType::kMat4}}};

template <std::size_t N>
void take(const JsonObject& object, const char* name, std::array<double, N>& target) {
  const std::vector<double> numbers = object.numbers(name, N);
  std::copy(numbers.begin(), numbers.end(), target.begin());
}

/// Whether `version` is a major and a minor version, as the specification wants it.
bool is_version(std::string_view version) {
  const std::size_t point = version.find('.');
  if (point == std::string_view::npos) return false;
  const auto are_digits = [](std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
  };
  return are_digits(version.substr(0, point)) && are_digits(version.substr(point + 1));
}

void check_version(const JsonObject& document) {
  const auto asset = document.object("asset");
  const std::string version = asset ? asset->text("version") : std::string();
  if (version.empty()) fail("it is not a glTF file: its JSON has no asset.version");
  const std::string least = asset->text("minVersion");
  if (!is_version(version) || !(least.empty() || is_version(least)))
    fail("its asset.version or asset.minVersion is not two numbers with a point between them, as in 2.0");
  if (!version.starts_with("2.")) fail("it is glTF version {}, only version 2 is supported", version);
  if (!least.empty() && least != "2.0" && !least.starts_with("1.") && !least.starts_with("0."))
    fail("it needs glTF version {}, only version 2.0 is supported", least);
}

Model::BufferView read_view(const JsonObject& source) {
  Model::BufferView view;
  view.buffer = source.required_whole_number("buffer");
  view.offset = source.whole_number("byteOffset").value_or(0);
  view.length = source.required_whole_number("byteLength");
  view.stride = source.whole_number("byteStride").value_or(0);
  constexpr std::size_t kMaxStride = 252;
  if (view.stride > kMaxStride || view.stride % 4 != 0)
    fail("{}.byteStride is {}, which is not a multiple of 4 up to {}", source.where(), view.stride,
         kMaxStride);
  return view;
}

Model::Sparse read_sparse(const JsonObject& source) {
  const auto indices = source.object("indices"), values = source.object("values");
  if (!indices || !values) fail("{} lacks its indices or its values", source.where());
  Model::Sparse sparse;
  sparse.count = source.required_whole_number("count");
  sparse.indices_view = indices->required_whole_number("bufferView");
  sparse.indices_offset = indices->whole_number("byteOffset").value_or(0);
  sparse.indices_type = indices->required_whole_number("componentType");
  sparse.values_view = values->required_whole_number("bufferView");
  sparse.values_offset = values->whole_number("byteOffset").value_or(0);
  return sparse;
}

Model::Accessor read_accessor(const JsonObject& source) {
  Model::Accessor accessor;
  accessor.view = source.whole_number("bufferView");
  accessor.offset = source.whole_number("byteOffset").value_or(0);
  accessor.component_type = source.required_whole_number("componentType");
  accessor.normalized = source.flag("normalized").value_or(false);
  accessor.count = source.required_whole_number("count");
  const std::string type = source.text("type");
  const auto known = std::find_if(kElementTypes.begin(), kElementTypes.end(),
                                  [&](const auto& entry) { return entry.first == type; });
  if (known == kElementTypes.end()) fail("{}.type is the unknown \"{}\"", source.where(), type);
  accessor.type = known->second;
  if (const auto sparse = source.object("sparse")) accessor.sparse = read_sparse(*sparse);
  return accessor;
}

/// Whether one of the accessors that a reader of Draco's data would fill has none of its own.
bool lacks_data(const Model::Primitive& primitive, const std::vector<Model::Accessor>& accessors) {
  const auto is_empty = [&](std::size_t index) {
    return index < accessors.size() && !accessors[index].view && !accessors[index].sparse;
  };
  const auto position = primitive.attributes.find("POSITION");
  return (primitive.indices && is_empty(*primitive.indices)) ||
         (position != primitive.attributes.end() && is_empty(position->second));
}

Model::Primitive read_primitive(const JsonObject& source, const std::vector<Model::Accessor>& accessors) {
  Model::Primitive primitive;
  primitive.mode = source.whole_number("mode").value_or(kTriangles);
  if (primitive.mode > kTriangleFan) fail("{}.mode is the unknown {}", source.where(), primitive.mode);
  const auto attributes = source.object("attributes");
  if (!attributes) fail("{} has no attributes", source.where());
  primitive.attributes = attributes->all_whole_numbers();
  primitive.indices = source.whole_number("indices");
  primitive.material = source.whole_number("material");
  for (const JsonObject& target : source.objects("targets"))
    primitive.targets.push_back(target.all_whole_numbers());
  primitive.is_compressed =
      source.extension("KHR_draco_mesh_compression") && lacks_data(primitive, accessors);
  return primitive;
}

Model::Mesh read_mesh(const JsonObject& source, const std::vector<Model::Accessor>& accessors) {
  Model::Mesh mesh;
  mesh.name = source.text("name");
  mesh.weights = source.numbers("weights");
  for (const JsonObject& primitive : source.objects("primitives"))
    mesh.primitives.push_back(read_primitive(primitive, accessors));
  for (const Model::Primitive& primitive : mesh.primitives)
    mesh.target_count = std::max(mesh.target_count, primitive.targets.size());
  if (!mesh.weights.empty() && mesh.weights.size() != mesh.target_count)
    fail("{} has {} weights, but {} morph targets", source.where(), mesh.weights.size(), mesh.target_count);
  return mesh;
}

Model::Node read_node(const JsonObject& source) {
  Model::Node node;
  node.name = source.text("name");
  node.children = source.whole_numbers("children");
  node.mesh = source.whole_number("mesh");
  node.skin = source.whole_number("skin");
  node.camera = source.whole_number("camera");
  if (source.has("matrix")) take(source, "matrix", node.matrix.emplace());
  take(source, "translation", node.transform.translation);
  take(source, "rotation", node.transform.rotation);
  take(source, "scale", node.transform.scale);
  node.weights = source.numbers("weights");
  if (const auto visibility = source.extension("KHR_node_visibility"))
    node.is_visible = visibility->flag("visible").value_or(true);
  if (const auto light = source.extension("KHR_lights_punctual"))
    node.light = light->required_whole_number("light");
  if (const auto instancing = source.extension("EXT_mesh_gpu_instancing")) {
    const auto attributes = instancing->object("attributes");
    node.instances = attributes ? attributes->all_whole_numbers() : Model::Attributes();
  }
  return node;
}

/// A color times a factor, both not negative, as floats can say it.
Vec3f read_light(const JsonObject& source, const char* name, Vec3f color, double factor,
                 const char* factor_name) {
  std::array<double, 3> c{color.x, color.y, color.z};
  take(source, name, c);
  const auto channel = [&](double x) {
    if (!(x >= 0) || !(factor >= 0) || !(x * factor <= std::numeric_limits<float>::max()))
      fail("{}.{} times {} is not light: {} times {}", source.where(), name, factor_name, x, factor);
    return static_cast<float>(x * factor);
  };
  return {channel(c[0]), channel(c[1]), channel(c[2])};
}

Model::Material read_material(const JsonObject& source) {
  Model::Material material;
  material.is_diffuse = false;
  if (const auto surface = source.object("pbrMetallicRoughness")) {
    std::array<double, 4> color{1, 1, 1, 1};
    take(*surface, "baseColorFactor", color);
    const auto channel = [&](std::size_t i) { return static_cast<float>(std::clamp(color[i], 0.0, 1.0)); };
    material.base_color = {channel(0), channel(1), channel(2)};
    material.has_textures = surface->has("baseColorTexture") || surface->has("metallicRoughnessTexture");
    material.is_diffuse = surface->number("metallicFactor").value_or(1) == 0 &&
                          surface->number("roughnessFactor").value_or(1) == 1;
  }
  const auto strength = source.extension("KHR_materials_emissive_strength");
  material.emission =
      read_light(source, "emissiveFactor", {0, 0, 0},
                 strength ? strength->number("emissiveStrength").value_or(1) : 1, "emissiveStrength");
  material.has_emissive_texture = source.has("emissiveTexture");
  material.has_textures = material.has_textures || source.has("normalTexture") ||
                          source.has("occlusionTexture") || material.has_emissive_texture;
  const std::string alpha = source.text("alphaMode");
  material.is_opaque = alpha.empty() || alpha == "OPAQUE";
  return material;
}

Model::Camera read_camera(const JsonObject& source) {
  const std::string type = source.text("type");
  if (type == "orthographic") return {};
  const auto perspective = source.object("perspective");
  if (type != "perspective" || !perspective)
    fail("{} is neither perspective nor orthographic", source.where());
  const double fov = perspective->number("yfov").value_or(0);
  if (!(fov > 0 && fov < std::numbers::pi))
    fail("{}.yfov is {}, which is not between 0 and pi", perspective->where(), fov);
  return {fov, {}};
}

Model::Light read_light(const JsonObject& source) {
  Model::Light light;
  const std::string type = source.text("type");
  using Kind = Model::Light::Kind;
  if (type != "directional" && type != "point" && type != "spot")
    fail("{}.type is the unknown \"{}\"", source.where(), type);
  light.kind = type == "directional" ? Kind::kDirectional : type == "spot" ? Kind::kSpot : Kind::kPoint;
  light.intensity =
      read_light(source, "color", {1, 1, 1}, source.number("intensity").value_or(1), "intensity");
  light.range = source.number("range").value_or(0);
  if (light.range < 0 || (source.has("range") && light.range == 0))
    fail("{}.range is {}, which is not above 0", source.where(), light.range);
  if (light.kind != Kind::kSpot) return light;
  const auto spot = source.object("spot");
  light.inner_cone = spot ? spot->number("innerConeAngle").value_or(0) : 0;
  light.outer_cone =
      spot ? spot->number("outerConeAngle").value_or(std::numbers::pi / 4) : std::numbers::pi / 4;
  if (!(light.inner_cone >= 0 && light.inner_cone <= light.outer_cone &&
        light.outer_cone <= std::numbers::pi / 2))
    fail("{} has a cone from {} to {}, which must not go down, and end at pi / 2 at most", source.where(),
         light.inner_cone, light.outer_cone);
  return light;
}

/// `read`, or why it cannot be read: of what nothing uses that does not matter.
template <class Part>
auto or_problem(Part (*read)(const JsonObject&)) {
  return [read](const JsonObject& source) {
    try {
      return read(source);
    } catch (const Problem& problem) {
      Part part;
      part.problem = problem.what();
      return part;
    }
  };
}

Model::Channel read_channel(const JsonObject& source) {
  const auto target = source.object("target");
  if (!target) fail("{} has no target", source.where());
  Model::Channel channel;
  channel.sampler = source.required_whole_number("sampler");
  channel.node = target->whole_number("node");
  channel.path = target->text("path");
  if (const auto pointer = target->extension("KHR_animation_pointer"))
    channel.pointer = pointer->text("pointer");
  return channel;
}

Model::Animation read_animation(const JsonObject& source) {
  Model::Animation animation;
  animation.name = source.text("name");
  for (const JsonObject& channel : source.objects("channels"))
    animation.channels.push_back(read_channel(channel));
  for (const JsonObject& sampler : source.objects("samplers"))
    animation.samplers.push_back({sampler.required_whole_number("input"),
                                  sampler.required_whole_number("output"), sampler.text("interpolation")});
  return animation;
}

void check_weights(const Model& model) {
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const std::size_t weights = model.nodes[i].weights.size(), targets = target_count(model, i);
    if (weights > 0 && weights != targets)
      fail("nodes[{}] has {} weights, but its mesh has {} morph targets", i, weights, targets);
  }
}

}  // namespace

std::size_t target_count(const Model& model, std::size_t node) {
  const Model::Index mesh = model.nodes[node].mesh;
  return mesh && *mesh < model.meshes.size() ? model.meshes[*mesh].target_count : 0;
}

std::size_t component_count(ElementType type) {
  constexpr std::array<std::size_t, 7> kCounts = {1, 2, 3, 4, 4, 9, 16};
  return kCounts[static_cast<std::size_t>(type)];
}

Model read_model(const nlohmann::json& json) {
  const JsonObject document(json, "");
  check_version(document);
  const std::vector<std::string> required = document.texts("extensionsRequired");
  check_required_extensions(required);
  Model model;
  model.extensions = document.texts("extensionsUsed");
  model.extensions.insert(model.extensions.end(), required.begin(), required.end());
  const auto read_all = [](const std::optional<JsonObject>& owner, const char* name, auto read, auto& parts) {
    if (!owner) return;
    for (const JsonObject& part : owner->objects(name)) parts.push_back(read(part));
  };
  read_all(document, "bufferViews", read_view, model.views);
  read_all(document, "accessors", read_accessor, model.accessors);
  read_all(
      document, "meshes", [&](const JsonObject& mesh) { return read_mesh(mesh, model.accessors); },
      model.meshes);
  read_all(document, "nodes", read_node, model.nodes);
  read_all(document, "materials", or_problem(read_material), model.materials);
  read_all(document, "cameras", or_problem(read_camera), model.cameras);
  read_all(document, "animations", read_animation, model.animations);
  read_all(document.extension("KHR_lights_punctual"), "lights", or_problem<Model::Light>(read_light),
           model.lights);
  read_all(
      document, "skins",
      [](const JsonObject& skin) {
        return Model::Skin{skin.whole_numbers("joints"), skin.whole_number("inverseBindMatrices")};
      },
      model.skins);
  read_all(
      document, "scenes",
      [](const JsonObject& scene) {
        return Model::Scene{scene.text("name"), scene.whole_numbers("nodes")};
      },
      model.scenes);
  model.default_scene = document.whole_number("scene");
  check_weights(model);
  return model;
}

}  // namespace stbvh::harness::gltf
