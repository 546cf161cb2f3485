#include "harness/scenes/embree_xml/writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "harness/scenes/default_sun.h"
#include "harness/scenes/embree_xml/disc_light.h"
#include "harness/scenes/embree_xml/time_seen.h"
#include "harness/scenes/light_check.h"
#include "harness/scenes/reach.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {
namespace embree_xml {
namespace {

/// Bytes of positions and indices up to which they stand in the text, for people to read.
constexpr std::size_t kMostTextBytes = 4096;
/// The sun and the sky of a scene without light: nearly what `stbvh-ab render` shows it under.
constexpr Vec3f kSunIrradiance{5.2f, 4.9f, 4.2f};
constexpr Vec3f kSkyRadiance{0.45f, 0.50f, 0.58f};

std::string words(Vec3f v) {
  return fmt::format("{} {} {}", v.x, v.y, v.z);
}

/// For attributes, in which Embree's loader refuses numbers below the least normal float.
float normal(float x) {
  return std::fpclassify(x) == FP_SUBNORMAL ? 0.0f : x;
}

Vec3f normal(Vec3f v) {
  return {normal(v.x), normal(v.y), normal(v.z)};
}

float largest(Vec3f v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Cameras that are nearer to the origin are written larger: denormals times this are normal.
constexpr float kTiny = 0x1p-62f;
constexpr double kTinyScale = 0x1p-64;

/// A direction as it is or, where readers may stumble over its length, of unit length.
Vec3f moderate(Vec3f direction) {
  const float size = largest(direction);
  return size > 0x1p-32f && size < 0x1p32f ? direction : to_float(normalize(to_double(direction)));
}

bool is_black(Vec3f v) {
  return v.x == 0 && v.y == 0 && v.z == 0;
}

bool has_light(const Scene& scene) {
  return !scene.directional_lights.empty() || !scene.point_lights.empty() || scene.environment ||
         std::any_of(scene.meshes.begin(), scene.meshes.end(),
                     [](const Mesh& mesh) { return !is_black(mesh.material.emission); });
}

DirectionalLight default_sun(const Camera& camera) {
  return {.direction = to_float(-normalize(to_default_sun(camera))), .irradiance = kSunIrradiance};
}

/// Of the disc; read back it gives a finite irradiance again, also where rounding would make that infinite.
Vec3f radiance_of(const DirectionalLight& light) {
  const double angle = projected_solid_angle(light.half_angle_degrees);
  const auto channel = [&](float irradiance) {
    const auto radiance = static_cast<float>(static_cast<double>(irradiance) / angle);
    const bool is_read_as_infinite =
        std::isfinite(radiance) && !std::isfinite(static_cast<float>(static_cast<double>(radiance) * angle));
    return is_read_as_infinite ? std::nextafter(radiance, 0.0f) : radiance;
  };
  return {channel(light.irradiance.x), channel(light.irradiance.y), channel(light.irradiance.z)};
}

/// The mean over all directions.
Vec3f mean_radiance(const Environment& environment) {
  if (environment.width == 0) return environment.radiance;
  Vec3 sum{0, 0, 0};
  double weights = 0;
  for (std::size_t y = 0; y < environment.height; ++y) {
    const double weight =
        std::sin(kPi * (static_cast<double>(y) + 0.5) / static_cast<double>(environment.height));
    for (std::size_t x = 0; x < environment.width; ++x)
      sum = sum + to_double(environment.pixels[y * environment.width + x]) * weight;
    weights += weight * static_cast<double>(environment.width);
  }
  const Vec3 mean = sum * (1 / weights), factor = to_double(environment.radiance);
  return to_float({mean.x * factor.x, mean.y * factor.y, mean.z * factor.z});
}

class Writer {
 public:
  Writer(const Scene& scene, const SceneWarning& warn) : scene_(scene), warn_(warn) {
    in_text_ = scene.buffer_bytes() <= kMostTextBytes;
  }

  /// What can be read again: not the meshes that Embree cannot show. Throws SceneFileError where these are
  /// all.
  EmbreeXml write() {
    line("<?xml version=\"1.0\"?>\n<scene>");
    camera();
    lights();
    bool is_empty = true;
    for (const Mesh& mesh : scene_.meshes) {
      if (mesh.triangle_count() == 0 || !is_seen(mesh)) continue;
      is_empty = false;
      add_mesh(mesh);
    }
    line("</scene>");
    if (const std::string sentence = unseen_meshes(scene_); !sentence.empty()) warn(sentence);
    if (is_empty) throw SceneFileError(fmt::format("{}: there is no mesh to write", scene_.name));
    return std::move(result_);
  }

 private:
  void line(std::string_view text) {
    result_.xml += text;
    result_.xml += '\n';
  }

  void warn(const std::string& sentence) {
    if (warn_) warn_(sentence);
  }

  /// Where all of it is next to the origin it is written larger, in a transform that makes it small again.
  void camera() {
    if (!scene_.camera_steps.empty()) warn("The camera moves; it is written where it is at first.");
    const Camera& c = scene_.camera;
    const bool is_tiny = std::max(largest(c.position), largest(c.target)) < kTiny;
    const double scale = is_tiny ? kTinyScale : 1;
    const Vec3 from = to_double(c.position) * (1 / scale), to = to_double(c.target) * (1 / scale);
    const double share = share_within_reach(from, to - from);
    const Camera written{.position = normal(to_float(from)),
                         .target = normal(to_float(share < 1 ? from + (to - from) * share : to)),
                         .up = normal(moderate(c.up)),
                         .vertical_fov_degrees = c.vertical_fov_degrees};
    for (const Camera& camera : {c, written}) {
      if (const std::string_view problem = problem_of(camera); !problem.empty())
        return warn(fmt::format("The camera is not written: it {}.", problem));
    }
    if (is_tiny) line(fmt::format(R"(<Transform><AffineSpace scale="{0} {0} {0}"/>)", float{kTinyScale}));
    line(fmt::format(R"(<PerspectiveCamera name="default" from="{}" to="{}" up="{}" fov="{}"/>)",
                     words(written.position), words(written.target), words(written.up),
                     written.vertical_fov_degrees));
    if (is_tiny) line("</Transform>");
  }

  void lights() {
    if (!has_light(scene_)) {
      directional_light(default_sun(scene_.camera));
      ambient_light(kSkyRadiance);
      return;
    }
    for (const DirectionalLight& light : scene_.directional_lights) {
      if (const std::string flaw = flaw_of(light); flaw.empty()) {
        directional_light(light);
      } else {
        warn(fmt::format("A directional light is not written: it {}.", flaw));
      }
    }
    if (!scene_.point_lights.empty()) warn("Lights from points are not written.");
    if (!scene_.environment) return;
    if (scene_.environment->width > 0) warn("The environment is a picture; its mean is written.");
    const Vec3f mean = mean_radiance(*scene_.environment);
    if (const std::string flaw = flaw_of(mean); flaw.empty()) {
      ambient_light(mean);
    } else {
      warn(fmt::format("The environment is not written: it {}.", flaw));
    }
  }

  void ambient_light(Vec3f radiance) {
    line(fmt::format("<AmbientLight><L>{}</L></AmbientLight>", words(radiance)));
  }

  /// The light travels along the third column of its map.
  void directional_light(const DirectionalLight& light) {
    const Vec3 z = normalize(to_double(light.direction));
    const Vec3 x = perpendicular(z), y = cross(z, x);
    const Vec3f fx = to_float(x), fy = to_float(y), fz = light.direction;
    const std::string space = fmt::format("<AffineSpace>{} {} {} 0 {} {} {} 0 {} {} {} 0</AffineSpace>", fx.x,
                                          fy.x, fz.x, fx.y, fy.y, fz.y, fx.z, fy.z, fz.z);
    const Vec3f radiance = radiance_of(light);
    if (light.half_angle_degrees > 0 && flaw_of(radiance).empty()) {
      line(fmt::format("<DistantLight>{}<L>{}</L><halfAngle>{}</halfAngle></DistantLight>", space,
                       words(radiance), light.half_angle_degrees));
    } else {  // a point of light, or too small a disc for what it shines with
      line(fmt::format("<DirectionalLight>{}<E>{}</E></DirectionalLight>", space, words(light.irradiance)));
    }
  }

  /// An element that defines the material when it comes first and names it from then on.
  std::string material(const Material& m) {
    std::string code, parameters;
    const auto add = [&](const char* type, const char* name, const std::string& value) {
      parameters += fmt::format(R"(<{0} name="{1}">{2}</{0}>)", type, name, value);
    };
    switch (m.kind) {
      case Material::Kind::kDiffuse:
        code = "OBJ";
        add("float3", "Kd", words(m.color));
        break;
      case Material::Kind::kGlossy:
        code = "Plastic";
        add("float3", "pigmentColor", words(m.color));
        add("float", "eta", fmt::format("{}", m.index_of_refraction));
        add("float", "roughness", fmt::format("{}", m.roughness));
        break;
      case Material::Kind::kMirror:
        code = "Mirror";
        add("float3", "reflectance", words(m.color));
        break;
      case Material::Kind::kGlass:
        code = "Dielectric";
        add("float3", "transmission", words(m.color));
        add("float", "etaInside", fmt::format("{}", m.index_of_refraction));
        break;
    }
    if (!is_black(m.emission) && flaw_of(m.emission).empty()) {
      add("float3", "emission", words(m.emission));
      if (!std::exchange(warned_of_emission_, true))
        warn("Meshes that emit light stay dark in Embree's tools.");
    }
    const std::string content =
        fmt::format(R"(<code>"{}"</code><parameters>{}</parameters>)", code, parameters);
    const auto [known, is_new] = materials_.try_emplace(content, materials_.size());
    if (!is_new) return fmt::format(R"(<material id="material{}"/>)", known->second);
    return fmt::format(R"(<material id="material{}">{}</material>)", known->second, content);
  }

  template <class T>
  void array(const char* name, std::span<const T> numbers, std::size_t per_element) {
    if (in_text_) {
      line(fmt::format("<{0}>{1}</{0}>", name, fmt::join(numbers, " ")));
      return;
    }
    line(fmt::format(R"(<{} ofs="{}" size="{}"/>)", name, offset_, numbers.size() / per_element));
    result_.binary.emplace_back(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
    offset_ += numbers.size_bytes();
  }

  void add_mesh(const Mesh& mesh) {
    std::string name = mesh.name;  // Embree reads no entities
    std::replace_if(
        name.begin(), name.end(),
        [](char c) {
          return c < ' ' || c > '~' || std::string_view("&<>\"'").find(c) != std::string_view::npos;
        },
        '_');
    const bool has_range = !mesh.is_static() && (mesh.time_range.begin != 0 || mesh.time_range.end != 1);
    if (has_range)
      line(fmt::format(R"(<TimeRange time="{} {}">)", normal(mesh.time_range.begin),
                       normal(mesh.time_range.end)));
    line(fmt::format(R"(<TriangleMesh name="{}">)", name));
    line(material(mesh.material));
    if (!mesh.is_static()) line("<animated_positions>");
    for (const VertexBuffer& step : mesh.steps) {
      static_assert(sizeof(Vec3f) == 3 * sizeof(float));
      array("positions", std::span<const float>(&step.data()->x, 3 * step.size()), 3);
    }
    if (!mesh.is_static()) line("</animated_positions>");
    array("triangles", std::span<const std::uint32_t>(mesh.indices), 3);
    line("</TriangleMesh>");
    if (has_range) line("</TimeRange>");
  }

  const Scene& scene_;
  const SceneWarning& warn_;
  EmbreeXml result_;
  bool in_text_ = false;
  std::size_t offset_ = 0;
  std::map<std::string, std::size_t> materials_;  ///< what is in the element, and its number
  bool warned_of_emission_ = false;
};

}  // namespace
}  // namespace embree_xml

std::filesystem::path embree_binary_file(const std::filesystem::path& xml_file) {
  std::filesystem::path file = xml_file;
  return file.replace_extension(".bin");
}

EmbreeXml to_embree_xml(const Scene& scene, const SceneWarning& warn) {
  return embree_xml::Writer(scene, warn).write();
}

}  // namespace stbvh::harness
