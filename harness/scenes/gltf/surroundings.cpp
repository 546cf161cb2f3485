#include "harness/scenes/gltf/surroundings.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness::gltf {
namespace {

constexpr double kDegreesPerRadian = 180 / kPi;

Vec3 column(const Affine& map, std::size_t i) {
  return {map.row[0][i], map.row[1][i], map.row[2][i]};
}

/// As float, and small enough to be computed with.
bool is_usable(Vec3 v) {
  const auto is_small = [](double x) { return std::abs(x) < static_cast<double>(kMaxCoordinate); };
  return is_small(v.x) && is_small(v.y) && is_small(v.z);
}

/// The middle of the scene's bounds.
Vec3 middle(const Scene& scene) {
  const Box3f box = scene.bounds();
  return 0.5 * (to_double(box.lower) + to_double(box.upper));
}

/// Looks along -z of its node, with y up; what is sharp is as far away as the middle of the scene. Nothing
/// where the node leaves it no direction.
std::optional<Camera> camera_of(const Affine& node, double vertical_fov, Vec3 middle_of_scene) {
  const Vec3 position = column(node, 3), back = column(node, 2), up = column(node, 1);
  if (!is_usable(position) || !is_usable(back) || !is_usable(up)) return std::nullopt;
  const Vec3 forward = normalize(-back);
  const double depth = dot(middle_of_scene - position, forward);
  Camera camera;
  camera.position = to_float(position);
  camera.target = to_float(position + forward * (depth > 0 ? depth : 1));
  camera.up = to_float(normalize(up));
  camera.vertical_fov_degrees = static_cast<float>(vertical_fov * kDegreesPerRadian);
  if (!looks_somewhere(camera)) return std::nullopt;
  return camera;
}

/// What a file says of the cameras of a scene.
struct CameraNodes {
  std::optional<std::size_t> first;  ///< node of the first perspective one
  double vertical_fov = 0;           ///< its, in radians
  std::size_t orthographic = 0, others = 0;
};

CameraNodes find_cameras(const Model& model, const std::vector<std::size_t>& nodes) {
  CameraNodes found;
  for (const std::size_t node : nodes) {
    const Model::Index index = model.nodes[node].camera;
    if (!index) continue;
    if (*index >= model.cameras.size()) fail("node {} refers to the missing camera {}", node, *index);
    const std::optional<double> fov = model.cameras[*index].vertical_fov;
    if (!fov) {
      ++found.orthographic;
    } else if (found.first) {
      ++found.others;
    } else {
      found.first = node;
      found.vertical_fov = *fov;
    }
  }
  return found;
}

/// Where the camera at `node` is at `steps` times; none where it looks nowhere at one of them.
std::vector<Camera> camera_path(const Timeline& timeline, std::size_t node, double vertical_fov,
                                std::size_t steps, Vec3 middle_of_scene) {
  const Rig rig = timeline.rig().chain(node);
  const Timeline own = timeline.part(rig);
  std::vector<Camera> path;
  for (std::size_t i = 0; i < steps; ++i) {
    const double fraction = steps > 1 ? static_cast<double>(i) / static_cast<double>(steps - 1) : 0;
    const auto camera = camera_of(own.pose(fraction).world[rig.slot(node)], vertical_fov, middle_of_scene);
    if (!camera) return {};
    path.push_back(*camera);
  }
  return path;
}

void add_camera(const Model& model, const Timeline& timeline, const std::vector<std::size_t>& nodes,
                std::size_t steps, const SceneWarning& warn, Scene& scene) {
  const CameraNodes cameras = find_cameras(model, nodes);
  if (cameras.orthographic > 0)
    warn(fmt::format("left out, as only perspective ones are read: {} orthographic camera{}",
                     cameras.orthographic, cameras.orthographic == 1 ? "" : "s"));
  if (cameras.others > 0)
    warn(fmt::format("left out, as the first is taken: {} more camera{}", cameras.others,
                     cameras.others == 1 ? "" : "s"));
  scene.camera = framing_camera(scene);
  scene.is_framed = true;
  if (!cameras.first) return;
  const bool moves = !timeline.is_instant() && timeline.rig().moves(*cameras.first);
  std::vector<Camera> path =
      camera_path(timeline, *cameras.first, cameras.vertical_fov, moves ? steps : 1, middle(scene));
  if (path.empty()) {
    warn("left out: a camera that does not look anywhere");
    return;
  }
  scene.camera = path.front();
  scene.is_framed = false;
  if (path.size() > 1) scene.camera_steps = std::move(path);
}

/// A light that stands still, of intensity `light.intensity` along -z of its node.
void add_light(const Model::Light& light, const Affine& node, Scene& scene) {
  const Vec3f direction = to_float(normalize(-column(node, 2)));
  if (light.kind == Model::Light::Kind::kDirectional) {
    scene.directional_lights.push_back({.direction = direction, .irradiance = light.intensity});
    return;
  }
  PointLight point{.position = to_float(column(node, 3)), .intensity = light.intensity};
  if (light.kind == Model::Light::Kind::kSpot) {
    point.axis = direction;
    point.inner_angle_degrees = static_cast<float>(light.inner_cone * kDegreesPerRadian);
    point.outer_angle_degrees = static_cast<float>(light.outer_cone * kDegreesPerRadian);
  }
  scene.point_lights.push_back(point);
}

void add_lights(const Model& model, const Timeline& timeline, const std::vector<std::size_t>& nodes,
                const SceneWarning& warn, Scene& scene) {
  const bool has_lights =
      std::any_of(nodes.begin(), nodes.end(), [&](std::size_t node) { return model.nodes[node].light; });
  if (!has_lights) return;
  const Rig& rig = timeline.rig();
  const Pose pose = timeline.pose(0);
  std::size_t moving = 0, with_range = 0, nowhere = 0;
  for (const std::size_t node : nodes) {
    const Model::Index index = model.nodes[node].light;
    if (!index) continue;
    if (*index >= model.lights.size()) fail("node {} refers to the missing light {}", node, *index);
    if (!timeline.is_instant() && (rig.moves(node) || rig.blinks(node))) ++moving;
    if (!pose.visible[rig.slot(node)]) continue;
    const Affine& world = pose.world[rig.slot(node)];
    if (!is_usable(column(world, 3)) || !is_usable(column(world, 2))) {
      ++nowhere;
      continue;
    }
    if (model.lights[*index].range > 0) ++with_range;
    add_light(model.lights[*index], world, scene);
  }
  const auto tell = [&](std::size_t count, const char* what) {
    if (count > 0) warn(fmt::format("{}: {} light{}", what, count, count == 1 ? "" : "s"));
  };
  tell(moving, "standing still as when the shutter opens, although the animation moves or hides them");
  tell(with_range, "shown without their range");
  tell(nowhere, "left out, as their places are not finite");
}

}  // namespace

void add_surroundings(const Model& model, const Timeline& timeline, const std::vector<std::size_t>& nodes,
                      std::size_t steps, const SceneWarning& warn, Scene& scene) {
  add_camera(model, timeline, nodes, steps, warn, scene);
  add_lights(model, timeline, nodes, warn, scene);
}

}  // namespace stbvh::harness::gltf
