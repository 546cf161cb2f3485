#include "builder/mesh_parts.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>

#include "builder/build_context.h"
#include "builder/index_table.h"

namespace stbvh {

namespace {

constexpr std::size_t kChunk = 8192;
constexpr std::size_t kTables = 4;  ///< of places, at once
constexpr std::size_t kSampledVertices = 256;
constexpr std::size_t kSmallComponent = 8;  ///< with fewer triangles components stay with the rest
constexpr std::size_t kMostParts = 16;
/// Of all primitive segments: what parts together, and one by itself, must save.
constexpr double kLeastSaving = 0.1, kLeastSavingOfOne = 0.01;

/// Which vertices of a mesh are connected, by triangles or by their places: a forest in which many threads
/// link roots at once, always to smaller ones, so that it is the same for any number of them.
class Components {
 public:
  explicit Components(const BuildMesh& mesh)
      : mesh_(mesh), parents_(mesh.view().steps[0].count), used_(parents_.size()) {
    std::iota(parents_.begin(), parents_.end(), 0u);
    const tbb::blocked_range<std::size_t> all(0, mesh.view().triangle_count, kChunk);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& chunk) {
      for (std::size_t prim = chunk.begin(); prim != chunk.end(); ++prim) {
        const TriangleIndices t = mesh.triangle(prim);
        if (!mesh.is_valid(t)) continue;
        unite(t[0], t[1]);
        unite(t[0], t[2]);
        for (const std::uint32_t v : t) std::atomic_ref(used_[v]).store(1, std::memory_order_relaxed);
      }
    });
  }

  /// Connects vertices of triangles that are at the same place at any step. Throws BuildCancelled.
  void connect_places(BuildProgress& progress) {
    const std::size_t steps = mesh_.segments() + 1;
    tbb::parallel_for(std::size_t{0}, kTables, [&](std::size_t first) {
      for (std::size_t step = first; step < steps; step += kTables) {
        progress.poll();
        connect_places_at(step);
      }
    });
  }

  /// A vertex that stands for the component, the first.
  std::uint32_t of(std::uint32_t vertex) {
    for (;;) {
      std::atomic_ref<std::uint32_t> link(parents_[vertex]);
      std::uint32_t parent = link.load(std::memory_order_relaxed);
      if (parent == vertex) return vertex;
      const std::uint32_t next = std::atomic_ref(parents_[parent]).load(std::memory_order_relaxed);
      link.compare_exchange_weak(parent, next, std::memory_order_relaxed);  // the next search is shorter
      vertex = next;
    }
  }

 private:
  void connect_places_at(std::size_t step) {
    // With zeros of one sign.
    const auto place = [&](std::uint32_t vertex) {
      const Vec3f p = mesh_.position(step, vertex);
      return Vec3f{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
    };
    // Another in each process: nobody can choose places that meet in one chain of the table.
    const auto seed = reinterpret_cast<std::uintptr_t>(parents_.data());
    IndexTable by_place(parents_.size());
    for (std::uint32_t v = 0; v < parents_.size(); ++v) {
      if (used_[v] == 0) continue;
      const Vec3f p = place(v);
      std::uint64_t hash = seed;
      for (const float x : {p.x, p.y, p.z})
        hash = (hash ^ std::bit_cast<std::uint32_t>(x)) * 0x9E3779B97F4A7C15u;
      const std::uint32_t first = by_place.find_or_add(hash, v, [&](std::uint32_t other) {
        const Vec3f q = place(other);
        return std::memcmp(&p, &q, sizeof p) == 0;
      });
      unite(first, v);
    }
  }

  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = of(a);
      b = of(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t root = a;
      if (std::atomic_ref(parents_[a]).compare_exchange_strong(root, b, std::memory_order_relaxed)) return;
    }
  }

  const BuildMesh& mesh_;
  std::vector<std::uint32_t> parents_;
  std::vector<std::uint8_t> used_;  ///< by a valid triangle
};

/// Steps that components need, and how many segments all of these together save.
using StepsNeeded = std::map<std::vector<std::size_t>, std::size_t>;

/// A component with triangles enough.
struct Component {
  std::size_t triangles = 0;
  std::vector<std::uint32_t> vertices{};
  StepsNeeded::iterator steps{};
  double deviation = 0.0;
};

class PartFinder {
 public:
  PartFinder(BuildContext& context, const MeshView& view, const BuildMesh& whole)
      : context_(context), view_(view), whole_(whole), tolerance_(context.settings.tolerance) {}

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

  /// Throws BuildCancelled, and BuildMemory::LimitReached.
  std::vector<MeshPart> find() {
    // Of each vertex: parent, triangles, number, itself twice, four places of each table, and whether it is
    // used; of each triangle: its component, and itself twice; and the components.
    const CountedMemory counted(context_.memory,
                                view_.steps[0].count * ((5 + 4 * kTables) * sizeof(std::uint32_t) + 1) +
                                    view_.triangle_count * 3 * sizeof(std::uint32_t) +
                                    view_.triangle_count / kSmallComponent * 2 * sizeof(Component));
    Components components(whole_);
    if (is_in_one(components)) return {};
    components.connect_places(context_.progress);
    if (is_in_one(components)) return {};
    collect(components);
    tbb::parallel_for(std::size_t{0}, components_.size(), [&](std::size_t i) {
      context_.progress.check();
      reduce(components_[i]);
    });
    return choose();
  }

 private:
  bool is_in_one(Components& components) const {
    std::uint32_t only = kNoVertex;
    for (std::size_t prim = 0; prim < view_.triangle_count; ++prim) {
      const TriangleIndices t = view_.triangle(prim);
      if (!whole_.is_valid(t)) continue;
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
      if (!whole_.is_valid(t)) continue;
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
      if (number != kNoVertex) components_[number].vertices.push_back(v);
    }
  }

  void reduce(Component& component) {
    const VertexChoice vertices{component.vertices.size(),
                                [&](std::size_t v) { return component.vertices[v]; }};
    StepReduction reduction = reduce_steps(view_, vertices, whole_.steps_kept(), tolerance_);
    component.deviation = reduction.deviation;
    const std::size_t saved = component.triangles * (whole_.steps_kept().size() - reduction.kept.size());
    const std::size_t bytes = kBytesOfSet + reduction.kept.size() * sizeof(std::size_t);
    const std::scoped_lock lock(steps_mutex_);
    const auto [steps, is_new] = steps_needed_.try_emplace(std::move(reduction.kept), 0);
    if (is_new) steps_memory_.emplace_back(context_.memory, bytes);
    steps->second += saved;
    component.steps = steps;
  }

  /// Components that need the same steps, the more they save the earlier; the rest comes last.
  std::vector<MeshPart> choose() {
    struct Choice {
      StepsNeeded::const_iterator steps;
      std::size_t saved;
    };
    std::vector<Choice> choices;
    const double all =
        static_cast<double>(view_.triangle_count) * static_cast<double>(whole_.steps_kept().size() - 1);
    for (auto steps = steps_needed_.cbegin(); steps != steps_needed_.cend(); ++steps) {
      if (static_cast<double>(steps->second) >= kLeastSavingOfOne * all)
        choices.push_back({steps, steps->second});
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
      const Component& component = components_[i];
      for (std::size_t part = 0; part < choices.size(); ++part) {
        if (choices[part].steps != component.steps) continue;
        part_of_component[i] = part;
        parts[part].steps.kept = component.steps->first;
        parts[part].steps.deviation = std::max(parts[part].steps.deviation, component.deviation);
      }
    }
    for (std::uint32_t prim = 0; prim < view_.triangle_count; ++prim) {
      const std::uint32_t component = component_of_prim_[prim];
      parts[component == kNoVertex ? choices.size() : part_of_component[component]].prims.push_back(prim);
    }
    if (parts.back().prims.empty()) parts.pop_back();
    return parts;
  }

  static constexpr std::size_t kBytesOfSet = 128;  ///< of a node of StepsNeeded, about

  BuildContext& context_;
  const MeshView& view_;
  const BuildMesh& whole_;
  float tolerance_;
  std::vector<Component> components_;
  StepsNeeded steps_needed_;
  std::deque<CountedMemory> steps_memory_;
  std::mutex steps_mutex_;
  std::vector<std::uint32_t> component_of_prim_;  ///< index of components_; kNoVertex: the rest
};

/// None where `whole` is better built as it is, or no memory may be taken for the search.
std::vector<MeshPart> find_parts(BuildContext& context, const MeshView& view, const BuildMesh& whole) {
  if (!(context.settings.tolerance >= 0.0f) || whole.is_static()) return {};
  if (view.triangle_count < 2 * kSmallComponent || view.steps[0].count > kNoVertex) return {};
  PartFinder finder(context, view, whole);
  if (!finder.may_have_parts()) return {};
  try {
    return finder.find();
  } catch (const BuildMemory::LimitReached&) {
    return {};
  }
}

}  // namespace

void add_mesh(BuildContext& context, const MeshView& view, std::size_t index) {
  BuildMesh whole(view, index, context.settings.tolerance);
  std::vector<MeshPart> parts = find_parts(context, view, whole);
  for (MeshPart& part : parts) context.meshes.emplace_back(whole, view, std::move(part), context.memory);
  if (parts.empty()) context.meshes.push_back(std::move(whole));
}

}  // namespace stbvh
