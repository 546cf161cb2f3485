#include "harness/scenes/gltf/gltf.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/finite_check.h"
#include "harness/scenes/gltf/adaptive_steps.h"
#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/gltf_file.h"
#include "harness/scenes/gltf/key_steps.h"
#include "harness/scenes/gltf/left_out.h"
#include "harness/scenes/gltf/pose.h"
#include "harness/scenes/gltf/primitive.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/gltf/size_check.h"
#include "harness/scenes/gltf/surroundings.h"
#include "harness/scenes/gltf/timeline.h"
#include "harness/scenes/gltf/visibility.h"
#include "harness/scenes/step_times.h"

namespace stbvh::harness {
namespace gltf {
namespace {

bool same_bits(const VertexBuffer& a, const VertexBuffer& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3f)) == 0;
}

Material material_of(const Model& model, std::size_t mesh, Model::Index index) {
  Material material;
  if (!index) return material;
  if (*index >= model.materials.size()) fail("mesh {} refers to the missing material {}", mesh, *index);
  const Model::Material& source = model.materials[*index];
  if (!source.problem.empty()) fail("{}", source.problem);
  material.color = source.base_color;
  // Where a texture says, mostly not everywhere, what emits, nothing does.
  if (!source.has_emissive_texture) material.emission = source.emission;
  return material;
}

std::string mesh_name(const Model& model, std::size_t node, std::size_t primitive) {
  const Model::Node& source = model.nodes[node];
  const Model::Mesh& mesh = model.meshes[*source.mesh];
  std::string name = !source.name.empty() ? source.name : mesh.name;
  if (name.empty()) name = fmt::format("node {}", node);
  return mesh.primitives.size() == 1 ? name : fmt::format("{} #{}", name, primitive);
}

struct NamedPrimitive {
  std::string name;
  Material material;
  Primitive primitive;
};

/// Those skins that nodes with a mesh have; the others are empty.
std::vector<Skin> read_skins(const Model& model, const std::vector<std::size_t>& nodes) {
  std::vector<Skin> skins(model.skins.size());
  std::vector<bool> is_read(skins.size(), false);
  for (const std::size_t node : nodes) {
    const Model::Index skin = model.nodes[node].skin;
    if (!skin || !model.nodes[node].mesh || (*skin < skins.size() && is_read[*skin])) continue;
    Skin read = read_skin(model, *skin);
    skins[*skin] = std::move(read);
    is_read[*skin] = true;
  }
  return skins;
}

class PrimitiveReader {
 public:
  PrimitiveReader(const Model& model, const std::vector<Skin>& skins) : model_(model), skins_(skins) {}

  void add_node(std::size_t node) {
    const Model::Index mesh = model_.nodes[node].mesh;
    if (!mesh) return;
    const std::vector<Affine> instances = read_instances(model_, node);
    const auto& sources = model_.meshes[*mesh].primitives;
    for (const std::size_t i : with_triangles(*mesh)) {
      check_cancelled();
      Primitive primitive{.node = node, .geometry = geometry(node, sources[i]), .skin = {}, .instance = {}};
      if (primitive.geometry->indices.empty()) continue;
      if (primitive.geometry->influences.per_vertex > 0) primitive.skin = model_.nodes[node].skin;
      if (primitive.skin) check_joints(*primitive.geometry, skins_[*primitive.skin]);
      add_instances(primitive, primitive.skin ? std::vector<Affine>(1) : instances,
                    mesh_name(model_, node, i), material_of(model_, *mesh, sources[i].material));
    }
  }

  std::vector<NamedPrimitive> take() { return std::move(primitives_); }

 private:
  /// The numbers of a mesh's primitives that are read; looked for once, as many nodes may have it.
  const std::vector<std::size_t>& with_triangles(std::size_t mesh) {
    const auto [known, is_new] = with_triangles_.try_emplace(mesh);
    const auto& sources = model_.meshes[mesh].primitives;
    for (std::size_t i = 0; is_new && i < sources.size(); ++i) {
      if (has_triangles(sources[i])) known->second.push_back(i);
    }
    return known->second;
  }

  std::shared_ptr<const Geometry> geometry(std::size_t node, const Model::Primitive& source) {
    const bool is_skinned = model_.nodes[node].skin.has_value();
    std::shared_ptr<const Geometry>& known = geometries_[{&source, is_skinned}];
    if (!known) known = read_geometry(model_, source, is_skinned);
    return known;
  }

  void add_instances(Primitive primitive, const std::vector<Affine>& instances, const std::string& name,
                     const Material& material) {
    for (std::size_t i = 0; i < instances.size(); ++i) {
      primitive.instance = instances[i];
      primitives_.push_back(
          {instances.size() == 1 ? name : fmt::format("{} [{}]", name, i), material, primitive});
    }
  }

  const Model& model_;
  const std::vector<Skin>& skins_;
  std::map<std::pair<const Model::Primitive*, bool>, std::shared_ptr<const Geometry>> geometries_;
  std::map<std::size_t, std::vector<std::size_t>> with_triangles_;
  std::vector<NamedPrimitive> primitives_;
};

/// A primitive while it is to be seen.
struct Part {
  const NamedPrimitive* source;
  Interval interval;

  bool is_whole() const { return interval.is_whole(); }
};

/// In the order of the primitives.
std::vector<Part> visible_parts(const std::vector<NamedPrimitive>& primitives, const Visibility& visibility) {
  std::vector<Part> parts;
  for (const NamedPrimitive& source : primitives) {
    for (const Interval& interval : visibility.of(source.primitive.node))
      parts.push_back({&source, interval});
  }
  return parts;
}

double step_fraction(std::size_t step, std::size_t steps) {
  return steps > 1 ? static_cast<double>(step) / static_cast<double>(steps - 1) : 0;
}

using Steps = std::vector<VertexBuffer>;

/// Steps of a part, and their ray times where they are not equidistant.
struct Motion {
  Steps steps;
  std::vector<float> times;
};

/// One step if all are the same.
void merge_if_still(Steps& steps) {
  const bool still = std::all_of(steps.begin() + 1, steps.end(),
                                 [&](const VertexBuffer& step) { return same_bits(steps.front(), step); });
  if (still) steps.resize(1);
}

bool moves(const Part& part, const Timeline& timeline) {
  const Primitive& primitive = part.source->primitive;
  return !timeline.is_instant() && timeline.rig().moves_mesh(primitive.node, primitive.skin);
}

Rig::Follows follows(const Part& part) {
  const Primitive& primitive = part.source->primitive;
  return {primitive.node, primitive.skin, primitive.geometry->influences.used};
}

/// The rig of those of `parts` that are numbered so; one for all of them, so that they share its poses.
Rig rig_of(const std::vector<Part>& parts, const std::vector<std::size_t>& numbers, const Rig& whole) {
  std::vector<Rig::Follows> meshes;
  for (const std::size_t p : numbers) meshes.push_back(follows(parts[p]));
  return whole.part(meshes);
}

/// `count` positions of each part that moves, at equidistant times while it is visible, one of the others.
/// Parts that are visible at the same times share poses.
std::vector<Motion> equidistant_steps(const std::vector<Part>& parts, const Timeline& timeline,
                                      std::size_t count) {
  std::map<std::pair<double, double>, std::vector<std::size_t>> moving;  // by when they are visible
  std::vector<Motion> result(parts.size());
  const Pose first = timeline.pose(0);
  for_all(parts.size(), [&](std::size_t p) {
    if (!moves(parts[p], timeline))
      result[p].steps.push_back(deform(parts[p].source->primitive, timeline.rig(), first));
  });
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (!result[p].steps.empty()) continue;
    result[p].steps.resize(count);
    moving[{parts[p].interval.begin, parts[p].interval.end}].push_back(p);
  }
  const std::vector<std::pair<std::pair<double, double>, std::vector<std::size_t>>> groups(moving.begin(),
                                                                                           moving.end());
  for_all(groups.size(), [&](std::size_t g) {
    const auto& interval = groups[g].first;
    const std::vector<std::size_t>& numbers = groups[g].second;  // Clang 14 captures no structured bindings
    const Rig rig = rig_of(parts, numbers, timeline.rig());
    const Timeline own = timeline.part(rig, interval.first, interval.second);
    for_all(count, [&](std::size_t i) {
      const Pose pose = own.pose(step_fraction(i, count));
      for (const std::size_t p : numbers) {
        check_cancelled();
        result[p].steps[i] = deform(parts[p].source->primitive, rig, pose);
      }
    });
    for (const std::size_t p : numbers) merge_if_still(result[p].steps);
  });
  return result;
}

/// Of the bounds over the shutter, which are looked at 33 times; 0 if no vertex is anywhere then.
double scene_diagonal(const std::vector<Part>& parts, const Timeline& timeline) {
  constexpr std::size_t kLooks = 33;
  Box3f box = Box3f::empty();
  for (std::size_t i = 0; i < kLooks; ++i) {
    check_cancelled();
    const Pose pose = timeline.pose(step_fraction(i, kLooks));
    const NamedPrimitive* last = nullptr;  // parts of a primitive stand together
    for (const Part& part : parts) {
      if (part.source == last || (i > 0 && !moves(part, timeline))) continue;
      last = part.source;
      const VertexBuffer positions = deform(part.source->primitive, timeline.rig(), pose);
      for (const Vec3f& p : positions.span()) {
        if (is_valid_position(p)) extend(box, p);
      }
    }
  }
  if (box.upper.x < box.lower.x) return 0;
  return std::hypot(double{box.upper.x} - box.lower.x, double{box.upper.y} - box.lower.y,
                    double{box.upper.z} - box.lower.z);
}

/// Ray times while a part is visible.
TimeRange range_of(const Part& part) {
  return {static_cast<float>(part.interval.begin), static_cast<float>(part.interval.end)};
}

/// Those that need more steps than there can be to stay within a share of the diagonal.
struct TooFew {
  std::size_t meshes = 0;
  double furthest = 0;  ///< of the diagonal

  void add(double deviation, double share, double diagonal) {
    meshes += deviation > share * diagonal ? 1u : 0u;
    furthest = std::max(furthest, deviation / diagonal);
  }
};

/// Calls make(part, its timeline, diagonal) for each part that moves, and gives the others one step; tells
/// `warn` of those that are further than `share` of the diagonal from their true places then.
template <class Make>
std::vector<Motion> chosen_steps(const std::vector<Part>& parts, const Timeline& timeline, double share,
                                 std::size_t most_steps, const SceneWarning& warn, const Make& make) {
  const double diagonal = scene_diagonal(parts, timeline);
  std::vector<Motion> result;
  TooFew too_few;
  const Pose first = timeline.pose(0);
  for (const Part& part : parts) {
    const Primitive& primitive = part.source->primitive;
    Motion& motion = result.emplace_back();
    if (!moves(part, timeline)) {
      motion.steps.push_back(deform(primitive, timeline.rig(), first));
      continue;
    }
    const Rig::Follows mesh = follows(part);
    const Rig rig = timeline.rig().part({&mesh, 1});
    too_few.add(
        make(part, timeline.part(rig, part.interval.begin, part.interval.end), share * diagonal, motion),
        share, diagonal);
  }
  if (too_few.meshes > 0) {
    warn(
        fmt::format("{} of {} meshes stay further than {:.3g} of the diagonal from their true places even "
                    "with {} steps; the furthest {:.3g}",
                    too_few.meshes, parts.size(), share, most_steps, too_few.furthest));
  }
  return result;
}

/// As many steps for each part as it needs.
std::vector<Motion> adaptive_steps(const std::vector<Part>& parts, const Timeline& timeline, double share,
                                   const SceneWarning& warn) {
  return chosen_steps(parts, timeline, share, kMaxSceneSteps, warn,
                      [](const Part& part, const Timeline& own, double tolerance, Motion& motion) {
                        AdaptiveSteps chosen = choose_steps(part.source->primitive, own, tolerance);
                        motion.steps = std::move(chosen.steps);
                        return chosen.deviation;
                      });
}

/// At the keys of what each part follows; without times where these are equidistant.
std::vector<Motion> keyed_steps(const std::vector<Part>& parts, const Timeline& timeline, double share,
                                double most_bytes, const SceneWarning& warn) {
  return chosen_steps(parts, timeline, share, kMaxSteps, warn,
                      [&](const Part& part, const Timeline& own, double tolerance, Motion& motion) {
                        KeySteps keyed =
                            steps_at_keys(part.source->primitive, own, range_of(part), tolerance, most_bytes);
                        for (const VertexBuffer& step : keyed.steps)
                          most_bytes -= static_cast<double>(step.size() * sizeof(Vec3f));
                        motion.steps = std::move(keyed.steps);
                        merge_if_still(motion.steps);
                        if (motion.steps.size() > 1 && !are_equidistant(keyed.times))
                          motion.times = std::move(keyed.times);
                        return keyed.deviation;
                      });
}

Mesh make_mesh(const Part& part, Motion motion) {
  Mesh mesh;
  mesh.name = part.source->name;
  mesh.material = part.source->material;
  mesh.indices = part.source->primitive.geometry->indices;
  mesh.steps = std::move(motion.steps);
  mesh.step_times = std::move(motion.times);
  if (part.is_whole()) return mesh;
  mesh.time_range = range_of(part);
  if (mesh.is_static()) mesh.steps.push_back(mesh.steps.front());  // those with one step are always visible
  return mesh;
}

std::vector<Motion> make_motions(const Model& model, const std::vector<Part>& parts, const Timeline& timeline,
                                 const GltfOptions& options, const SceneWarning& warn) {
  if (options.at_keys) {
    return keyed_steps(parts, timeline, options.largest_deviation.value_or(kKeyDeviation),
                       most_bytes_of(model), warn);
  }
  if (options.largest_deviation) return adaptive_steps(parts, timeline, *options.largest_deviation, warn);
  return equidistant_steps(parts, timeline, options.steps);
}

void check_options(const GltfOptions& options) {
  if (options.steps < 1 || options.steps > kMaxSceneSteps) {
    fail("{} steps are asked for, but only 1 to {} are possible", options.steps, kMaxSceneSteps);
  }
  if (options.largest_deviation && !(*options.largest_deviation > 0 && *options.largest_deviation < 1)) {
    fail("a deviation of {} diagonals is asked for, but it must lie between 0 and 1",
         *options.largest_deviation);
  }
}

Scene load(const std::filesystem::path& file, const GltfOptions& options, const SceneWarning& tell) {
  const SceneWarning warn = [&](const std::string& sentence) {
    if (tell) tell(fmt::format("{}: {}", file.string(), sentence));
  };
  check_options(options);
  const Model model = read_gltf_file(file);
  const NodeTree tree(model);
  const std::vector<std::size_t> nodes = nodes_of_scene(model, tree, options.scene, warn);
  const std::optional<ClipSource> clip_source = find_clip(model, options.clip);
  const bool chooses_steps = options.at_keys || options.largest_deviation;
  // How many keys make is known when they are made.
  const std::size_t most_steps = options.at_keys ? 1 : chooses_steps ? kMaxSceneSteps : options.steps;
  check_sizes(model, tree, nodes, clip_source ? &*clip_source : nullptr, most_steps);
  warn_of_what_is_left_out(model, nodes, clip_source ? &*clip_source : nullptr, warn);

  std::optional<Clip> clip;
  if (clip_source) clip = read_clip(model, *clip_source);
  const std::vector<Skin> skins = read_skins(model, nodes);
  const Rig rig(model, tree, clip ? &*clip : nullptr, skins);
  const Timeline timeline(rig, clip ? &*clip : nullptr, options);
  PrimitiveReader reader(model, skins);
  for (const std::size_t node : nodes) reader.add_node(node);
  const std::vector<NamedPrimitive> primitives = reader.take();
  if (primitives.empty()) fail("its scene has no triangles");
  const Visibility visibility(model, tree, timeline, most_bytes_of(model));
  check_sizes(model, tree, nodes, clip_source ? &*clip_source : nullptr, most_steps, &visibility);
  const std::vector<Part> parts = visible_parts(primitives, visibility);
  if (parts.empty() && !may_be_empty(options.shutter)) fail("all meshes of its scene are hidden");

  std::vector<Motion> motions = make_motions(model, parts, timeline, options, warn);
  Scene scene;
  scene.name = file.stem().string();
  for (std::size_t i = 0; i < parts.size(); ++i)
    scene.meshes.push_back(make_mesh(parts[i], std::move(motions[i])));
  leave_out_invalid_triangles(scene, file, tell);
  if (scene.meshes.empty() && !parts.empty()) fail("none of its triangles can be shown");
  const std::size_t camera_steps = chooses_steps ? camera_step_count(options.shutter) : options.steps;
  add_surroundings(model, timeline, nodes, camera_steps, warn, scene);
  return scene;
}

}  // namespace
}  // namespace gltf

Scene load_gltf(const std::filesystem::path& file, const GltfOptions& options, const SceneWarning& warn) {
  try {
    return gltf::load(file, options, warn);
  } catch (const gltf::Problem& problem) {
    throw SceneFileError(fmt::format("{}: {}", file.string(), problem.what()));
  } catch (const std::bad_alloc&) {
    throw SceneFileError(fmt::format("{}: there is not enough memory for it", file.string()));
  }
}

}  // namespace stbvh::harness
