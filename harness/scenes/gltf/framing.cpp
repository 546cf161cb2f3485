#include "harness/scenes/gltf/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/scenes/reach.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness::gltf {
namespace {

constexpr double kMargin = 0.98;  // share of the picture that the scene's larger side takes

/// One axis of the picture: the planes that bound it on either side, pushed outwards until every vertex is
/// between them. Where they meet is the nearest place for the camera.
struct Reach {
  double above = -std::numeric_limits<double>::infinity();
  double below = -std::numeric_limits<double>::infinity();

  void add(double offset, double slope, double depth) {
    above = std::max(above, offset - slope * depth);
    below = std::max(below, -offset - slope * depth);
  }
  /// The largest depth of a camera that still has everything between its planes, and where it then stands.
  double camera_depth(double slope) const { return -(above + below) / (2 * slope); }
  double camera_offset() const { return (above - below) / 2; }
};

template <class Visit>
void for_each_vertex(const Scene& scene, Visit&& visit) {
  for (const Mesh& mesh : scene.meshes) {
    for (const VertexBuffer& step : mesh.steps) {
      for (const Vec3f& p : step.span()) {
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) visit(to_double(p));
      }
    }
  }
}

/// From where the scene is looked at: its middle where it is so far from the origin, for its size, that
/// rounding would say where the camera is.
Vec3 local_origin(const Box3f& box) {
  const Vec3 middle = 0.5 * (to_double(box.lower) + to_double(box.upper));
  const double far = std::max({std::abs(middle.x), std::abs(middle.y), std::abs(middle.z)});
  return diagonal(box) < 0x1p-20 * far ? middle : Vec3{0, 0, 0};
}

Camera looking(Vec3 position, Vec3 target) {
  Camera camera;
  camera.position = to_float(position);
  camera.target = to_float(target);
  return camera;
}

bool is_usable(const Camera& camera) {
  return is_within_reach(to_double(camera.target)) && problem_of(camera).empty();
}

/// At `target` from a place in the direction of `back`: as far away as that is long, or nearer so that it is
/// within reach, or further so that floats tell the two places apart. The default camera where none does.
Camera nearest_usable(Vec3 target, Vec3 back) {
  const auto nearest = [](double x) { return std::clamp(x, -kFarthest, kFarthest); };
  target = {nearest(target.x), nearest(target.y), nearest(target.z)};
  back = back * share_within_reach(target, back);
  for (;; back = back * 2) {
    const Camera camera = looking(target + back, target);
    if (is_usable(camera)) return camera;
    if (!(length(back) > 0) || !is_within_reach(back)) return {};
  }
}

}  // namespace

Camera framing_camera(const Scene& scene) {
  const Camera camera;
  const Vec3 forward = normalize(Vec3{-0.5715, -0.3429, -0.7454});
  const Vec3 right = normalize(cross(forward, Vec3{0, 1, 0}));
  const Vec3 up = cross(right, forward);
  const double slope_up = kMargin * std::tan(camera.vertical_fov_degrees * kPi / 360);
  const double slope_right = kPictureAspect * slope_up;
  Reach reach_right, reach_up;
  double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
  const Vec3 origin = local_origin(scene.bounds());
  for_each_vertex(scene, [&](Vec3 far) {
    const Vec3 p = far - origin;
    const double depth = dot(p, forward);
    reach_right.add(dot(p, right), slope_right, depth);
    reach_up.add(dot(p, up), slope_up, depth);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  });
  const double depth = std::min(reach_right.camera_depth(slope_right), reach_up.camera_depth(slope_up));
  const double distance = (nearest + farthest) / 2 - depth;
  if (!std::isfinite(distance) || !(distance > 0)) return camera;
  const Vec3 position =
      origin + right * reach_right.camera_offset() + up * reach_up.camera_offset() + forward * depth;
  const Vec3 target = position + forward * distance;
  const Camera framing = looking(position, target);
  return is_usable(framing) ? framing : nearest_usable(target, forward * -distance);
}

}  // namespace stbvh::harness::gltf
