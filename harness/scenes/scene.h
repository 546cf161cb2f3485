/// What every stage of the harness works on: animated triangle meshes and a camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stbvh/mesh_view.h"
#include "stbvh/vec.h"

namespace stbvh {
class SavedStructure;
}

namespace stbvh::harness {

/// Positions of one step. Keeps one more element behind the last: Embree reads 16 bytes at each vertex.
class VertexBuffer {
 public:
  VertexBuffer() = default;
  explicit VertexBuffer(std::size_t count) : storage_(count + 1, Vec3f{0, 0, 0}) {}

  std::size_t size() const { return storage_.empty() ? 0 : storage_.size() - 1; }
  Vec3f* data() { return storage_.data(); }
  const Vec3f* data() const { return storage_.data(); }
  Vec3f& operator[](std::size_t i) { return storage_[i]; }
  const Vec3f& operator[](std::size_t i) const { return storage_[i]; }
  std::span<const Vec3f> span() const { return {storage_.data(), size()}; }

 private:
  std::vector<Vec3f> storage_;
};

/// How a surface reflects, the same everywhere on it: there are no textures.
struct Material {
  enum class Kind {
    kDiffuse,  ///< Lambert
    kGlossy,   ///< a diffuse base under a rough coat
    kMirror,   ///< perfect reflection
    kGlass,    ///< smooth dielectric, closed surfaces
  };
  Kind kind = Kind::kDiffuse;
  Vec3f color{0.7f, 0.7f, 0.7f};     ///< reflectance, or of glass transmittance; linear RGB
  float roughness = 0.3f;            ///< of kGlossy, 0 to 1
  float index_of_refraction = 1.5f;  ///< of kGlass and of the coat of kGlossy
  Vec3f emission{0, 0, 0};           ///< radiance; a mesh that emits is an area light, on both sides
};

/// Makes `box` as large as it must be for `p` to be in it.
void extend(Box3f& box, Vec3f p);

/// Length of the box's diagonal; 0 if it is empty.
double diagonal(const Box3f& box);

/// Most steps of a mesh that Embree takes, and with it the programs that scenes are compared with: those of
/// files that have a step for each position, and of what is made with a number of steps. A mesh may have
/// kMaxSteps.
inline constexpr std::size_t kMaxSceneSteps = 129;

/// A triangle mesh with one vertex buffer for each step.
struct Mesh {
  std::string name;
  std::vector<std::uint32_t> indices;  ///< 3 for each triangle
  /// Of each triangle its face in the file, which polygons and cages have; empty: the triangles are the
  /// faces.
  std::vector<std::uint32_t> faces;
  std::vector<VertexBuffer> steps;  ///< 1 (static) to kMaxSteps, all of the same size
  TimeRange time_range;             ///< in ray time, default [0, 1]; steps are equidistant over it
  /// Of each step in ray time, instead of `time_range`, which is not looked at then: strictly increasing,
  /// each 0 or a normal float, as far apart as MeshView asks for. Empty: equidistant, or static.
  std::vector<float> step_times;
  std::uint32_t mask = 0xFFFFFFFFu;
  Material material;  ///< for pictures

  std::size_t triangle_count() const { return indices.size() / 3; }
  std::size_t segment_count() const { return steps.empty() ? 0 : steps.size() - 1; }
  bool is_static() const { return steps.size() <= 1; }
  std::uint32_t face_of(std::uint32_t triangle) const {
    return triangle < faces.size() ? faces[triangle] : triangle;
  }
  bool has_step_times() const { return !step_times.empty(); }
  /// From the first step to the last. A mesh that moves is there only then.
  TimeRange motion_range() const;
  /// When step `step` of a mesh that moves is.
  double step_time(std::size_t step) const;
};

/// Width over height of the pictures that cameras are made for.
inline constexpr double kPictureAspect = 16.0 / 9.0;

struct Camera {
  Vec3f position{0, 0, 5};
  Vec3f target{0, 0, 0};
  Vec3f up{0, 1, 0};
  float vertical_fov_degrees = 40.0f;
};

/// Why no rays can be sent through a camera, as in "is too far away"; empty where they can.
std::string_view problem_of(const Camera& camera);

/// Light from far away, out of a disc.
struct DirectionalLight {
  Vec3f direction{0, -1, 0};     ///< in which it travels; any length
  Vec3f irradiance{3, 3, 3};     ///< on a surface that faces it; linear RGB
  float half_angle_degrees = 0;  ///< of the disc; 0: hard shadows
};

/// Light from a point, in all directions or into a cone.
struct PointLight {
  Vec3f position{0, 0, 0};
  Vec3f intensity{1, 1, 1};         ///< irradiance on a surface at distance 1 that faces it; linear RGB
  Vec3f axis{0, -1, 0};             ///< of the cone; any length
  float inner_angle_degrees = 180;  ///< from the axis: up to it the light is whole,
  float outer_angle_degrees = 180;  ///< from here on there is none
};

/// Light from all directions: a constant, or a picture of latitude and longitude.
struct Environment {
  Vec3f radiance{1, 1, 1};  ///< or what the picture is multiplied with
  std::size_t width = 0;    ///< of the picture; 0: there is none
  std::size_t height = 0;
  std::vector<Vec3f> pixels;  ///< rows from +y down to -y; columns from -z over +x, +z and -x back to -z
};

struct Scene {
  std::string name;
  std::vector<Mesh> meshes;
  Camera camera;
  bool is_framed = false;  ///< its file brings no camera: this one sees all that is there in the shutter
  std::vector<Camera> camera_steps;  ///< where it is over the ray times [0, 1], equidistant; empty: it stands
  std::vector<DirectionalLight> directional_lights;
  std::vector<PointLight> point_lights;
  std::optional<Environment> environment;  ///< without any light, pictures are lit by a sun and a sky
  /// How far structures that can may be from the motion, scene units; 0: within rounding.
  float tolerance = 0.0f;
  /// That structures that can may take; empty: as many as they like.
  std::optional<std::size_t> max_bytes;
  /// Of a file with a structure over these very meshes: structures that can need not be built.
  std::shared_ptr<const SavedStructure> saved;

  std::size_t triangle_count() const;
  /// Sum over triangles of max(segments, 1).
  std::size_t primitive_segment_count() const;
  /// Sum over meshes of their steps.
  std::size_t step_count() const;
  /// Bytes of all vertex and index buffers.
  std::size_t buffer_bytes() const;
  /// Union over all meshes and steps.
  Box3f bounds() const;
  /// The camera at a ray time: between two steps it moves linearly.
  Camera camera_at(double time) const;
};

}  // namespace stbvh::harness
