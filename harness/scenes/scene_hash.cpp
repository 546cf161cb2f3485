#include "harness/scenes/scene_hash.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

#include "harness/scenes/scene_views.h"
#include "stbvh/mesh_fingerprint.h"

namespace stbvh::harness {
namespace {

/// FNV-1a over two words at once, with other constants in each.
class Hash {
 public:
  void add(std::uint64_t word) {
    low_ = (low_ ^ word) * 0x100000001B3u;
    low_ ^= low_ >> 29;
    high_ = (high_ ^ word) * 0x9E3779B97F4A7C15u;
    high_ ^= high_ >> 31;
  }
  void add(float x) { add(std::uint64_t{std::bit_cast<std::uint32_t>(x)}); }
  void add(const Vec3f& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  void add(const Camera& camera) {
    add(camera.position);
    add(camera.target);
    add(camera.up);
    add(camera.vertical_fov_degrees);
  }
  void add(const Material& material) {
    add(static_cast<std::uint64_t>(material.kind));
    add(material.color);
    add(material.roughness);
    add(material.index_of_refraction);
    add(material.emission);
  }
  std::string text() const { return fmt::format("{:016x}{:016x}", high_, low_); }

 private:
  std::uint64_t low_ = 0xCBF29CE484222325u, high_ = 0x6C62272E07BB0142u;
};

}  // namespace

std::string scene_hash(const Scene& scene) {
  Hash hash;
  const SceneViews views(scene);
  for (const MeshFingerprint& mesh : fingerprints_of(views.meshes())) {
    for (const ContentHash& part : {mesh.shape, mesh.positions}) {
      hash.add(part.low);
      hash.add(part.high);
    }
  }
  for (const Mesh& mesh : scene.meshes) {
    hash.add(std::uint64_t{mesh.mask});
    hash.add(mesh.material);
    hash.add(std::uint64_t{mesh.faces.size()});
    for (const std::uint32_t face : mesh.faces) hash.add(std::uint64_t{face});
  }
  hash.add(scene.camera);
  hash.add(std::uint64_t{scene.camera_steps.size()});
  for (const Camera& camera : scene.camera_steps) hash.add(camera);
  hash.add(std::uint64_t{scene.directional_lights.size()});
  for (const DirectionalLight& light : scene.directional_lights) {
    hash.add(light.direction);
    hash.add(light.irradiance);
    hash.add(light.half_angle_degrees);
  }
  hash.add(std::uint64_t{scene.point_lights.size()});
  for (const PointLight& light : scene.point_lights) {
    hash.add(light.position);
    hash.add(light.intensity);
    hash.add(light.axis);
    hash.add(light.inner_angle_degrees);
    hash.add(light.outer_angle_degrees);
  }
  if (scene.environment) {
    hash.add(scene.environment->radiance);
    hash.add(std::uint64_t{scene.environment->width});
    for (const Vec3f& pixel : scene.environment->pixels) hash.add(pixel);
  }
  hash.add(scene.tolerance);
  return hash.text();
}

}  // namespace stbvh::harness
