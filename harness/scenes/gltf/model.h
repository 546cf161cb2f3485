/// A glTF 2.0 file as it is read: its parts refer to each other by indices that are not checked yet.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "harness/scenes/gltf/transform.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness::gltf {

enum ComponentType : std::size_t {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126,
};

enum class ElementType { kScalar, kVec2, kVec3, kVec4, kMat2, kMat3, kMat4 };
std::size_t component_count(ElementType type);

enum PrimitiveMode : std::size_t { kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6 };

struct Model {
  using Index = std::optional<std::size_t>;
  using Attributes = std::map<std::string, std::size_t>;  ///< accessors by name

  struct Buffer {
    std::shared_ptr<const std::vector<unsigned char>> source;  ///< one for all buffers of a URI
    std::span<const unsigned char> bytes;                      ///< the first of it
    std::string problem;  ///< why there are none; of concern only where they are used
  };
  struct BufferView {
    std::size_t buffer = 0;
    std::size_t offset = 0;
    std::size_t length = 0;
    std::size_t stride = 0;  ///< 0: elements lie close together
  };
  struct Sparse {
    std::size_t count = 0;
    std::size_t indices_view = 0, indices_offset = 0, indices_type = 0;
    std::size_t values_view = 0, values_offset = 0;
  };
  struct Accessor {
    Index view;  ///< none: all zero
    std::size_t offset = 0;
    std::size_t component_type = 0;
    bool normalized = false;
    std::size_t count = 0;
    ElementType type = ElementType::kScalar;
    std::optional<Sparse> sparse;
  };
  struct Primitive {
    std::size_t mode = kTriangles;
    Attributes attributes;
    Index indices, material;
    bool is_compressed = false;  ///< its vertices or indices are there in no other form
    std::vector<Attributes> targets;
  };
  struct Mesh {
    std::string name;
    std::vector<Primitive> primitives;
    std::size_t target_count = 0;  ///< morph targets of the primitive that has most
    std::vector<double> weights;   ///< one for each target, or none: all are 0
  };
  struct Node {
    std::string name;
    std::vector<std::size_t> children;
    Index mesh, skin, camera, light;
    std::optional<std::array<double, 16>> matrix;  ///< instead of `transform`, column by column
    TranslationRotationScale transform;
    std::vector<double> weights;  ///< one for each target of its mesh, or none: as the mesh says
    bool is_visible = true;
    std::optional<Attributes> instances;
  };
  struct Skin {
    std::vector<std::size_t> joints;
    Index inverse_bind;
  };
  struct Material {
    Vec3f base_color{1, 1, 1};
    Vec3f emission{0, 0, 0};
    bool has_textures = false, has_emissive_texture = false;
    bool is_opaque = true;
    bool is_diffuse = true;  ///< neither metal, which is the default, nor smooth
    std::string problem;     ///< why there is none; of concern only where it is used
  };
  struct Camera {
    std::optional<double> vertical_fov;  ///< radians; none: orthographic
    std::string problem;                 ///< as of a material
  };
  struct Light {
    enum class Kind { kDirectional, kPoint, kSpot };
    Kind kind = Kind::kPoint;
    Vec3f intensity{1, 1, 1};               ///< of a directional light its illuminance
    double range = 0;                       ///< 0: it has none
    double inner_cone = 0, outer_cone = 0;  ///< radians, of a spot
    std::string problem;                    ///< as of a material
  };
  struct Sampler {
    std::size_t input = 0, output = 0;
    std::string interpolation;
  };
  struct Channel {
    std::size_t sampler = 0;
    Index node;
    std::string path;
    std::string pointer;  ///< where the path is "pointer"
  };
  struct Animation {
    std::string name;
    std::vector<Channel> channels;
    std::vector<Sampler> samplers;
  };
  struct Scene {
    std::string name;
    std::vector<std::size_t> nodes;
  };

  std::vector<Buffer> buffers;
  std::vector<BufferView> views;
  std::vector<Accessor> accessors;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Skin> skins;
  std::vector<Material> materials;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  std::vector<Animation> animations;
  std::vector<Scene> scenes;
  Index default_scene;
  std::vector<std::string> extensions;  ///< used or required
  std::size_t bytes = 0;                ///< of the file and all that it refers to
};

/// Morph targets of a node's mesh; 0 where it has none.
std::size_t target_count(const Model& model, std::size_t node);

}  // namespace stbvh::harness::gltf
