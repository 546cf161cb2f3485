#include "builder/mesh_parts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <numeric>
#include <utility>

#include "builder/index_table.h"

namespace stbvh {

namespace {

constexpr std::size_t kSampledVertices = 256;
constexpr std::size_t kSmallComponent = 8;  ///< with fewer triangles components stay with the rest
constexpr std::size_t kMostParts = 16;
/// Of all primitive segments: what parts together, and one by itself, must save.
constexpr double kLeastSaving = 0.1, kLeastSavingOfOne = 0.01;

bool has_vertices(const BuildMesh& mesh, const TriangleIndices& triangle) {
  return std::ranges::all_of(triangle, [&](std::uint32_t v) { return v < mesh.view().steps[0].count; });
}

/// Which vertices of a mesh are connected, by triangles or by their places.
class Components {
 public:
  explicit Components(const BuildMesh& mesh) : mesh_(mesh), parents_(mesh.view().steps[0].count) {
    std::iota(parents_.begin(), parents_.end(), 0u);
    for (std::size_t prim = 0; prim < mesh.view().triangle_count; ++prim) {
      const TriangleIndices t = mesh.triangle(prim);
      if (!has_vertices(mesh, t)) continue;
      unite(t[0], t[1]);
      unite(t[0], t[2]);
    }
  }

  /// Connects vertices that are at the same place at any step.
  void connect_places() {
    for (std::size_t step = 0; step <= mesh_.segments(); ++step) {
      IndexTable by_place(parents_.size());
      for (std::uint32_t v = 0; v < parents_.size(); ++v) {
        const Vec3f p = place(step, v);
        std::uint64_t hash = 0;
        for (const float x : {p.x, p.y, p.z})
          hash = (hash ^ std::bit_cast<std::uint32_t>(x)) * 0x9E3779B97F4A7C15u;
        const std::uint32_t first = by_place.find_or_add(hash, v, [&](std::uint32_t other) {
          const Vec3f q = place(step, other);
          return std::memcmp(&p, &q, sizeof p) == 0;
        });
        unite(first, v);
      }
    }
  }

  /// A vertex that stands for the component, the first.
  std::uint32_t of(std::uint32_t vertex) {
    while (parents_[vertex] != vertex) vertex = parents_[vertex] = parents_[parents_[vertex]];
    return vertex;
  }

 private:
  /// With zeros of one sign.
  Vec3f place(std::size_t step, std::uint32_t vertex) const {
    const Vec3f p = mesh_.position(step, vertex);
    return {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
  }

  void unite(std::uint32_t a, std::uint32_t b) {
    a = of(a);
    b = of(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

  const BuildMesh& mesh_;
  std::vector<std::uint32_t> parents_;
};

/// A component with triangles enough.
struct Component {
  std::size_t triangles = 0;
  std::vector<std::uint32_t> vertices{};  ///< valid ones
  StepReduction steps{};
};

class PartFinder {
 public:
  PartFinder(const MeshView& view, const BuildMesh& whole, float tolerance)
      : view_(view), whole_(whole), tolerance_(tolerance) {}

  /// A guess from some vertices: most meshes are in one part, and are not looked at any further.
  bool may_have_parts() const {
    const std::size_t count = view_.steps[0].count;
    const std::size_t stride = std::max<std::size_t>(count / kSampledVertices, 1);
    const auto sampled = [&](std::size_t i) {
      return whole_.is_invalid(i * stride) ? kNoVertex : static_cast<std::uint32_t>(i * stride);
    };
    const VertexChoice vertices{(count + stride - 1) / stride, sampled};
    return dispensable_share(view_, vertices, whole_.steps_kept(), tolerance_) >= kLeastSaving;
  }

  std::vector<MeshPart> find() {
    Components components(whole_);
    if (is_in_one(components)) return {};
    components.connect_places();
    collect(components);
    tbb::parallel_for(std::size_t{0}, components_.size(), [&](std::size_t i) {
      Component& component = components_[i];
      const VertexChoice vertices{component.vertices.size(),
                                  [&](std::size_t v) { return component.vertices[v]; }};
      component.steps = reduce_steps(view_, vertices, whole_.steps_kept(), tolerance_);
    });
    return choose();
  }

 private:
  bool is_in_one(Components& components) const {
    std::uint32_t only = kNoVertex;
    for (std::size_t prim = 0; prim < view_.triangle_count; ++prim) {
      const TriangleIndices t = view_.triangle(prim);
      if (!has_vertices(whole_, t)) continue;
      const std::uint32_t component = components.of(t[0]);
      if (only == kNoVertex) only = component;
      if (component != only) return false;
    }
    return true;
  }

  void collect(Components& components) {
    const std::size_t count = view_.steps[0].count;
    std::vector<std::uint32_t> triangles(count);
    component_of_prim_.assign(view_.triangle_count, kNoVertex);
    for (std::size_t prim = 0; prim < view_.triangle_count; ++prim) {
      const TriangleIndices t = view_.triangle(prim);
      if (!has_vertices(whole_, t)) continue;
      component_of_prim_[prim] = components.of(t[0]);
      ++triangles[component_of_prim_[prim]];
    }
    std::vector<std::uint32_t> numbers(count, kNoVertex);
    for (std::uint32_t v = 0; v < count; ++v) {
      if (triangles[v] < kSmallComponent) continue;
      numbers[v] = static_cast<std::uint32_t>(components_.size());
      components_.push_back({triangles[v]});
    }
    for (std::uint32_t& component : component_of_prim_) {
      if (component != kNoVertex) component = numbers[component];
    }
    for (std::uint32_t v = 0; v < count; ++v) {
      const std::uint32_t number = numbers[components.of(v)];
      if (number != kNoVertex && !whole_.is_invalid(v)) components_[number].vertices.push_back(v);
    }
  }

  /// Components that need the same steps, the more they save the earlier; the rest comes last.
  std::vector<MeshPart> choose() {
    struct Choice {
      const std::vector<std::size_t>* steps;
      std::size_t saved;
    };
    const auto segments = [](std::size_t steps) { return steps - 1; };
    const std::size_t of_all = segments(whole_.steps_kept().size());
    std::map<std::vector<std::size_t>, std::size_t> saved_by_steps;
    for (const Component& component : components_) {
      saved_by_steps[component.steps.kept] +=
          component.triangles * (of_all - segments(component.steps.kept.size()));
    }
    std::vector<Choice> choices;
    const double all = static_cast<double>(view_.triangle_count) * static_cast<double>(of_all);
    for (const auto& [steps, saved] : saved_by_steps) {
      if (static_cast<double>(saved) >= kLeastSavingOfOne * all) choices.push_back({&steps, saved});
    }
    std::ranges::stable_sort(choices, std::ranges::greater{}, &Choice::saved);
    choices.resize(std::min(choices.size(), kMostParts - 1));
    std::size_t saved = 0;
    for (const Choice& choice : choices) saved += choice.saved;
    if (static_cast<double>(saved) < kLeastSaving * all) return {};

    std::vector<MeshPart> parts(choices.size() + 1);
    parts.back().steps = {whole_.steps_kept(), whole_.deviation()};
    std::vector<std::size_t> part_of_component(components_.size(), choices.size());
    for (std::size_t i = 0; i < components_.size(); ++i) {
      const StepReduction& steps = components_[i].steps;
      for (std::size_t part = 0; part < choices.size(); ++part) {
        if (*choices[part].steps != steps.kept) continue;
        part_of_component[i] = part;
        parts[part].steps.kept = steps.kept;
        parts[part].steps.deviation = std::max(parts[part].steps.deviation, steps.deviation);
      }
    }
    for (std::uint32_t prim = 0; prim < view_.triangle_count; ++prim) {
      const std::uint32_t component = component_of_prim_[prim];
      parts[component == kNoVertex ? choices.size() : part_of_component[component]].prims.push_back(prim);
    }
    if (parts.back().prims.empty()) parts.pop_back();
    return parts;
  }

  const MeshView& view_;
  const BuildMesh& whole_;
  float tolerance_;
  std::vector<Component> components_;
  std::vector<std::uint32_t> component_of_prim_;  ///< index of components_; kNoVertex: the rest
};

std::vector<MeshPart> find_parts(const MeshView& view, const BuildMesh& whole, float tolerance,
                                 BuildMemory& memory) {
  if (tolerance < 0.0f || whole.is_static() || view.triangle_count < 2 * kSmallComponent) return {};
  PartFinder finder(view, whole, tolerance);
  if (!finder.may_have_parts()) return {};
  // Of each vertex: parent, triangles, number, itself twice, and four places of a table; of each triangle:
  // its component, and itself twice; and the components.
  const CountedMemory counted(memory, view.steps[0].count * 9 * sizeof(std::uint32_t) +
                                          view.triangle_count * 3 * sizeof(std::uint32_t) +
                                          view.triangle_count / kSmallComponent * 2 * sizeof(Component));
  return finder.find();
}

}  // namespace

void add_mesh(std::vector<BuildMesh>& meshes, const MeshView& view, std::size_t index, float tolerance,
              BuildMemory& memory) {
  BuildMesh whole(view, index, tolerance);
  std::vector<MeshPart> parts = find_parts(view, whole, tolerance, memory);
  for (MeshPart& part : parts) meshes.emplace_back(whole, view, std::move(part), memory);
  if (parts.empty()) meshes.push_back(std::move(whole));
}

}  // namespace stbvh
