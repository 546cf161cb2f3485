#include "harness/scenes/scene_hash.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>

#include "harness/scenes/scene_views.h"
#include "stbvh/mesh_fingerprint.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace stbvh::harness {
namespace {

/// XXH3, 128 bits, of what is added, one after another.
class Hash {
 public:
  Hash() { XXH3_128bits_reset(&state_); }

  void add(std::uint64_t word) { add_bytes(&word, sizeof word); }
  void add(float x) { add_bytes(&x, sizeof x); }
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
  std::string text() const {
    const XXH128_hash_t hash = XXH3_128bits_digest(&state_);
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
  }

 private:
  void add_bytes(const void* bytes, std::size_t count) { XXH3_128bits_update(&state_, bytes, count); }

  XXH3_state_t state_;
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
