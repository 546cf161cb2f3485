#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/embree_xml/node.h"
#include "harness/scenes/embree_xml/problem.h"
#include "harness/scenes/reach.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::embree_xml {
namespace {

/// Where something is on its way down the graph.
struct Placement {
  std::vector<Affine> keys;  ///< none: where it is
  std::optional<TimeRange> time_range;

  bool moves() const { return keys.size() > 1; }
};

/// A step of `steps`, between the keys of something that has fewer or as many.
struct Between {
  std::size_t key;
  double fraction;  ///< on the way to the next key; 0 at the last
};

Between key_at(std::size_t step, std::size_t steps, std::size_t keys) {
  if (keys < 2 || steps < 2) return {0, 0};
  const std::size_t scaled = step * (keys - 1);
  const std::size_t key = scaled / (steps - 1);
  return {key, static_cast<double>(scaled % (steps - 1)) / static_cast<double>(steps - 1)};
}

/// Steps at which each of `a` and each of `b` equidistant keys is one.
std::size_t common_steps(std::size_t a, std::size_t b) {
  if (a < 2 || b < 2) return std::max(a, b);
  const std::size_t steps = std::lcm(a - 1, b - 1) + 1;
  if (steps > kMaxSceneSteps) {
    throw Problem(
        fmt::format("a motion of {} keys under one of {} keys needs {} common steps; {} are possible", b, a,
                    steps, kMaxSceneSteps));
  }
  return steps;
}

bool is_same(TimeRange a, TimeRange b) {
  return a.begin == b.begin && a.end == b.end;
}

Affine interpolated(const std::vector<Affine>& keys, Between at) {
  if (at.fraction == 0) return keys[at.key];
  Affine result = Affine::zero();
  result.add_scaled(keys[at.key], 1 - at.fraction);
  result.add_scaled(keys[at.key + 1], at.fraction);
  return result;
}

/// `child` inside `parent`.
Placement composed(const Placement& parent, const Transform& child) {
  if (child.keys.size() > kMaxSceneSteps)
    throw Problem(fmt::format("a transform has {} keys; {} are possible", child.keys.size(), kMaxSceneSteps));
  if (parent.keys.empty()) return {child.keys, child.time_range};
  Placement result;
  const bool child_moves = child.keys.size() > 1;
  if (parent.moves() && child_moves &&
      !is_same(parent.time_range.value_or(TimeRange{}), child.time_range.value_or(TimeRange{}))) {
    throw Problem("a transform that moves stands under one that moves over another time range");
  }
  result.time_range = child_moves ? child.time_range : parent.time_range;
  const std::size_t steps = common_steps(parent.keys.size(), child.keys.size());
  for (std::size_t i = 0; i < steps; ++i) {
    result.keys.push_back(interpolated(parent.keys, key_at(i, steps, parent.keys.size())) *
                          interpolated(child.keys, key_at(i, steps, child.keys.size())));
  }
  return result;
}

/// Positions of one step: `mesh` between its own steps, mapped; infinite beyond a float's range.
VertexBuffer placed_step(const Mesh& mesh, Between at, const Affine& map) {
  const VertexBuffer& from = mesh.steps[at.key];
  const VertexBuffer& to = mesh.steps[at.fraction == 0 ? at.key : at.key + 1];
  const auto lerp = [&](float a, float b) {
    return (1 - at.fraction) * static_cast<double>(a) + at.fraction * static_cast<double>(b);
  };
  VertexBuffer result(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    result[i] =
        to_float(map.apply({lerp(from[i].x, to[i].x), lerp(from[i].y, to[i].y), lerp(from[i].z, to[i].z)}));
  }
  return result;
}

/// The time range of a mesh that a moving placement is over.
TimeRange time_range_of(const Mesh& mesh, const Placement& placement) {
  const TimeRange range = placement.time_range.value_or(mesh.time_range);
  if (!mesh.is_static() && !is_same(range, mesh.time_range))
    throw Problem(
        fmt::format("the mesh \"{}\" moves over another time range than the transforms above it", mesh.name));
  return range;
}

class Flattener {
 public:
  void visit(const Node& node, const Placement& placement) {
    check_cancelled();
    if (const auto* const transform = std::get_if<Transform>(&node.content)) {
      const Placement below = composed(placement, *transform);
      for (const NodePtr& child : node.children) visit(*child, below);
      return;
    }
    if (const auto* const mesh = std::get_if<Mesh>(&node.content)) add_mesh(*mesh, placement);
    if (const auto* const light = std::get_if<DirectionalLight>(&node.content)) add_light(*light, placement);
    if (const auto* const light = std::get_if<AmbientLight>(&node.content)) add_light(*light);
    if (const auto* const camera = std::get_if<NamedCamera>(&node.content)) add_camera(*camera, placement);
    for (const NodePtr& child : node.children) visit(*child, placement);
  }

  FlatScene take() { return std::move(scene_); }

 private:
  void add_mesh(const Mesh& mesh, const Placement& placement) {
    const std::size_t steps =
        common_steps(std::max<std::size_t>(placement.keys.size(), 1), mesh.steps.size());
    bytes_ += mesh.steps.front().size() * steps * sizeof(Vec3f) + mesh.indices.size() * sizeof(std::uint32_t);
    if (bytes_ > kMaxSceneFileBytes)
      throw Problem(fmt::format("its instances need more than {} GB", kMaxSceneFileBytes >> 30));
    if (placement.keys.empty()) {
      scene_.meshes.push_back(mesh);
      return;
    }
    Mesh& placed = scene_.meshes.emplace_back();
    placed.name = mesh.name;
    placed.indices = mesh.indices;
    placed.mask = mesh.mask;
    placed.material = mesh.material;
    placed.time_range = placement.moves() ? time_range_of(mesh, placement) : mesh.time_range;
    placed.steps.resize(steps);
    for_all(steps, [&](std::size_t i) {
      const Affine map = interpolated(placement.keys, key_at(i, steps, placement.keys.size()));
      placed.steps[i] = placed_step(mesh, key_at(i, steps, mesh.steps.size()), map);
    });
  }

  static Vec3f mapped_point(Vec3f v, const Placement& placement) {
    if (placement.keys.empty()) return v;
    const Vec3 p = placement.keys.front().apply(to_double(v));
    if (!is_within_reach(p)) throw Problem("a transform moves a camera too far away");
    return to_float(p);
  }

  /// Its length is kept where floats can say it.
  static Vec3f mapped_direction(Vec3f v, const Placement& placement) {
    if (placement.keys.empty()) return v;
    Affine map = placement.keys.front();
    for (std::array<double, 4>& row : map.row) row[3] = 0;
    const Vec3 d = map.apply(to_double(v));
    const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    return to_float(largest > kFarthest || largest < 1 / kFarthest ? d * (1 / largest) : d);
  }

  void add_light(DirectionalLight light, const Placement& placement) {
    light.direction = mapped_direction(light.direction, placement);
    scene_.directional_lights.push_back(light);
  }

  void add_light(const AmbientLight& light) {
    const Vec3f sum = scene_.ambient.value_or(Vec3f{0, 0, 0});
    scene_.ambient = Vec3f{sum.x + light.radiance.x, sum.y + light.radiance.y, sum.z + light.radiance.z};
  }

  void add_camera(NamedCamera camera, const Placement& placement) {
    Camera& c = camera.camera;
    c.position = mapped_point(c.position, placement);
    c.target = mapped_point(c.target, placement);
    c.up = mapped_direction(c.up, placement);
    scene_.cameras.push_back(std::move(camera));
  }

  FlatScene scene_;
  std::size_t bytes_ = 0;
};

}  // namespace

FlatScene flatten(const Node& root) {
  if (root.leaves > kMaxLeaves)
    throw Problem(fmt::format("it has more than {} instances of meshes and lights", kMaxLeaves));
  Flattener flattener;
  flattener.visit(root, {});
  return flattener.take();
}

}  // namespace stbvh::harness::embree_xml
