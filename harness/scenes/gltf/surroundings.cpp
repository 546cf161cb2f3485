#include "harness/scenes/gltf/surroundings.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/gltf/transform.h"
#include "harness/scenes/reach.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness::gltf {
namespace {

constexpr double kDegreesPerRadian = 180 / kPi;

Vec3 column(const Affine& map, std::size_t i) {
  return {map.row[0][i], map.row[1][i], map.row[2][i]};
}

/// Nothing where it has no direction, or hardly any digits to tell it by.
std::optional<Vec3> direction(Vec3 v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest >= std::numeric_limits<double>::min()) || !std::isfinite(v.x + v.y + v.z))
    return std::nullopt;
  return normalize(Vec3{v.x / largest, v.y / largest, v.z / largest});
}

/// What looks or shines along -z of its node, with y up.
struct View {
  Vec3 forward, up;  ///< no length: there is none
};

std::optional<View> view_of(const Affine& node) {
  const auto back = direction(column(node, 2)), up = direction(column(node, 1));
  if (!back) return std::nullopt;
  return View{-*back, up.value_or(Vec3())};
}

/// Where a node has it in `pose`; where scales take a direction away, as it is turned without them.
std::optional<View> view_at(const Timeline& timeline, double fraction, const Pose& pose, std::size_t node) {
  const auto view = view_of(pose.world[timeline.rig().slot(node)]);
  if (view && length(view->up) > 0) return view;
  const Rig rig = timeline.rig().chain(node);
  const auto turned = view_of(timeline.part(rig).pose(fraction, Scaling::kNone).world[rig.slot(node)]);
  return turned ? turned : view;
}

/// The middle of the scene's bounds.
Vec3 middle(const Scene& scene) {
  const Box3f box = scene.bounds();
  return 0.5 * (to_double(box.lower) + to_double(box.upper));
}

/// What is sharp is as far away as the middle of the scene, but not so close that floats cannot tell where.
Camera camera_of(Vec3 position, const View& view, double vertical_fov, Vec3 middle_of_scene) {
  const double depth = dot(middle_of_scene - position, view.forward), least = 1e-4 * length(position);
  const Vec3 way = view.forward * (depth > least ? depth : std::max(1.0, least));
  Camera camera;
  camera.position = rounded(position);
  camera.target = rounded(position + way * share_within_reach(position, way));
  camera.up = to_float(view.up);
  camera.vertical_fov_degrees = static_cast<float>(vertical_fov * kDegreesPerRadian);
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
    const auto& [fov, problem] = model.cameras[*index];
    if (!problem.empty()) fail("{}", problem);
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

/// The camera at `node` at `steps` times.
std::vector<Camera> camera_path(const Timeline& timeline, std::size_t node, double vertical_fov,
                                std::size_t steps, Vec3 middle_of_scene) {
  const Rig rig = timeline.rig().chain(node);
  const Timeline own = timeline.part(rig);
  std::vector<Camera> path;
  for (std::size_t i = 0; i < steps; ++i) {
    const double fraction = steps > 1 ? static_cast<double>(i) / static_cast<double>(steps - 1) : 0;
    const Pose pose = own.pose(fraction);
    const Vec3 position = column(pose.world[rig.slot(node)], 3);
    const View view = view_at(own, fraction, pose, node).value_or(View());
    path.push_back(camera_of(position, view, vertical_fov, middle_of_scene));
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
  for (const Camera& camera : path) {
    if (const std::string_view problem = problem_of(camera); !problem.empty()) {
      warn(fmt::format("left out: a camera that {}", problem));
      return;
    }
  }
  scene.camera = path.front();
  scene.is_framed = false;
  if (path.size() > 1) scene.camera_steps = std::move(path);
}

/// A light that stands still, of intensity `light.intensity` along `forward`.
void add_light(const Model::Light& light, Vec3 position, Vec3 forward, Scene& scene) {
  if (light.kind == Model::Light::Kind::kDirectional) {
    scene.directional_lights.push_back({.direction = to_float(forward), .irradiance = light.intensity});
    return;
  }
  PointLight point{.position = to_float(position), .intensity = light.intensity};
  if (light.kind == Model::Light::Kind::kSpot) {
    point.axis = to_float(forward);
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
  std::size_t moving = 0, with_range = 0, far = 0, undirected = 0;
  for (const std::size_t node : nodes) {
    const Model::Index index = model.nodes[node].light;
    if (!index) continue;
    if (*index >= model.lights.size()) fail("node {} refers to the missing light {}", node, *index);
    const Model::Light& light = model.lights[*index];
    if (!light.problem.empty()) fail("{}", light.problem);
    if (!timeline.is_instant() && (rig.moves(node) || rig.blinks(node))) ++moving;
    if (!pose.visible[rig.slot(node)]) continue;
    using Kind = Model::Light::Kind;
    const Vec3 position = column(pose.world[rig.slot(node)], 3);
    if (light.kind != Kind::kDirectional && !is_within_reach(position)) {
      ++far;
      continue;
    }
    const auto view = light.kind == Kind::kPoint ? View() : view_at(timeline, 0, pose, node);
    if (!view) {
      ++undirected;
      continue;
    }
    if (light.range > 0) ++with_range;
    add_light(light, position, view->forward, scene);
  }
  const auto tell = [&](std::size_t count, const char* what) {
    if (count > 0) warn(fmt::format("{}: {} light{}", what, count, count == 1 ? "" : "s"));
  };
  tell(moving, "standing still as when the shutter opens, although the animation moves or hides them");
  tell(with_range, "shown without their range");
  tell(far, "left out, as they are too far away");
  tell(undirected, "left out, as their nodes give them no direction");
}

}  // namespace

void add_surroundings(const Model& model, const Timeline& timeline, const std::vector<std::size_t>& nodes,
                      std::size_t steps, const SceneWarning& warn, Scene& scene) {
  add_camera(model, timeline, nodes, steps, warn, scene);
  add_lights(model, timeline, nodes, warn, scene);
}

}  // namespace stbvh::harness::gltf
