/// Ours, with one of its ideas taken away (docs/algorithm.md): what each is worth.
///
/// Stored and traversed: by the kernels. Built: as the kernels do, with their step reduction, but for one
/// thing:
///
/// - `no-leaf-cost`: C_leaf counts primitive segments, as the paper's does, not leaves. What decides on
///   temporal splits is still the leaf, and still first.
/// - `no-temporal-first`: at each set, the cheaper of the best object split and the temporal split, by
/// the costs
///   of our leaves and the price of their memory.
/// - `no-tight-lines`: lines through the boxes at both ends of the range, moved outwards by the worst
/// violation
///   in between (as Embree's are); of inner nodes, those of all references. Whether a split pays is judged by
///   the tight ones.
/// - `no-static-side`: what stands still is split together with what moves.
/// - `no-optimal-collapse`: the child of the largest area is opened until there are eight.
/// - `no-meshlets`: references are triangles; what fits into one leaf when the splits arrive there
/// becomes one.
/// - `no-step-reduction`: steps are taken as they are given.
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "builder/mbsah.h"
#include "builder/motion_bounds.h"
#include "builder/sample_array.h"
#include "builder/temporal_split.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/mbsah_builder.h"
#include "harness/structures/gallery/weighted_split.h"

namespace stbvh::harness::gallery {
namespace {

// Leaf cost -------------------------------------------------------------------------------------------------

class NoLeafCost final : public MbsahBuilder {
 public:
  using MbsahBuilder::MbsahBuilder;

 private:
  static constexpr std::size_t kSample = 64;  // as the kernels' find_temporal_split()

  std::optional<Split> choose(const ReferenceSet& set) const override {
    if (const std::optional<TemporalSplit> split = find_temporal_split(context(), set)) {
      if (wanted_share(set, split->halves) >= kTemporalShare) return split->halves;
    }
    if (set.size() == 1) return std::nullopt;
    return find_weighted_split(context(), set);
  }

  /// Of the leaves that cost less in two halves, by their segments.
  float wanted_share(const ReferenceSet& set, const TimeHalves& halves) const {
    const std::size_t stride = (set.size() + kSample - 1) / kSample;
    std::size_t wanted = 0, count = 0;
    for (std::size_t i = 0; i < set.size(); i += stride, ++count) {
      ReferenceSet one;
      one.references = set.references.subspan(i, 1);
      one.range = set.range;
      one.update_bounds();
      double parts = 0.0;
      std::array<Reference, 1> storage;
      for (const ClosedTimeRange& half : halves)
        parts += leaf_cost(remake_references(context(), one, half, storage));
      wanted += parts < leaf_cost(one);
    }
    return static_cast<float>(wanted) / static_cast<float>(count);
  }
};

// Temporal first --------------------------------------------------------------------------------------------

class NoTemporalFirst final : public TopDown {
 public:
  using TopDown::TopDown;

 private:
  std::optional<Split> choose(const ReferenceSet& set) const override {
    std::optional<TimeHalves> halves;
    double in_time = 0.0;
    if (const std::optional<TemporalSplit> split = find_temporal_split(context(), set)) {
      halves = split->halves;
      TemporaryArray<Reference> storage(context().memory, set.size());
      for (const ClosedTimeRange& half : *halves)
        in_time += cost(remake_references(context(), set, half, storage.span()));
    }
    if (set.size() == 1) {
      if (halves && in_time < cost(set)) return *halves;
      return std::nullopt;
    }
    const ObjectSplit object = find_object_split(set);
    const double in_space = static_cast<double>(object.cost) * static_cast<double>(set.range.length()) +
                            context().price.of_bytes(1) * bytes(set);
    if (halves && in_time < in_space) return *halves;
    return object;
  }

  /// Of the leaves of a set, and of their memory.
  double cost(const ReferenceSet& set) const {
    if (set.size() == 0) return 0.0;
    return static_cast<double>(expected_area(set.bounds, set.range)) * static_cast<double>(set.size()) +
           context().price.of_bytes(1) * bytes(set);
  }
  double bytes(const ReferenceSet& set) const {
    double sum = 0.0;
    for (const Reference& reference : set.references) {
      const std::size_t steps = context().meshes[reference.mesh].steps_in(set.range);
      sum += static_cast<double>(inline_leaf_bytes(steps) + kNodeShareBytes);
    }
    return sum;
  }
};

// Tight lines -----------------------------------------------------------------------------------------------

/// Through the first and the last box, moved outwards until all are inside.
LinearBounds shifted_lines(std::span<const BoundsSample> samples) {
  const Box4 &begin = samples.front().box, &end = samples.back().box;
  F32x4 below(0.0f), above(0.0f);
  for (const BoundsSample& sample : samples) {
    const F32x4 f0(1.0f - sample.parameter), f1(sample.parameter);
    below = max(below, f0 * begin.lower + f1 * end.lower - sample.box.lower);
    above = max(above, sample.box.upper - (f0 * begin.upper + f1 * end.upper));
  }
  LinearBounds bounds{{begin.lower - below, begin.upper + above}, {end.lower - below, end.upper + above}};
  if (samples.size() <= 2) return bounds;
  // For the rounding of parameters and lines.
  const auto size = [](const Box4& box) { return max(abs(box.lower), abs(box.upper)); };
  const F32x4 pad = F32x4(0x1p-20f) * max(size(bounds.begin), size(bounds.end));
  for (Box4* const box : {&bounds.begin, &bounds.end}) *box = {box->lower - pad, box->upper + pad};
  return bounds;
}

class NoTightLines final : public TopDown {
 public:
  using TopDown::TopDown;

 private:
  void fit(ReferenceSet& set) const override {
    const BuildMesh* mesh = nullptr;
    std::optional<MotionSamples> samples;
    for (Reference& reference : set.references) {
      if (mesh != &context().meshes[reference.mesh]) {
        mesh = &context().meshes[reference.mesh];
        samples.emplace(*mesh, set.range);
      }
      if (mesh->is_static() || !samples->covers_range) continue;
      SampleArray<BoundsSample> boxes(samples->samples.size());
      const std::span<BoundsSample> used(boxes.data(), samples->samples.size());
      sample_boxes(*mesh, *samples, meshlet(reference).used_vertices(), used);
      reference = make_reference(shifted_lines(used), reference.mesh, reference.meshlet);
    }
    set.update_bounds();
  }

  LinearBounds inner_bounds(const ReferenceSet& set, const BinaryNode&, const BinaryNode&) const override {
    return set.bounds;
  }
};

// Static side -----------------------------------------------------------------------------------------------

class NoStaticSide final : public TopDown {
 public:
  using TopDown::TopDown;

 private:
  bool parts_still_from_moving() const override { return false; }
};

// Optimal collapse ------------------------------------------------------------------------------------------

class NoOptimalCollapse final : public TopDown {
 public:
  using TopDown::TopDown;

 private:
  void collapse(BinaryNode& root) const override {
    if (root.is_leaf()) return;
    std::array<BinaryNode*, kWidth> children{&root};
    std::size_t count = 1;
    while (count < kWidth) {
      BinaryNode** const end = children.data() + count;
      BinaryNode** const largest = std::max_element(children.data(), end, [](const auto* a, const auto* b) {
        return area_to_open(*a) < area_to_open(*b);
      });
      if ((*largest)->is_leaf()) break;
      BinaryInner& opened = as_inner(**largest);
      *largest = &opened.child(0);
      children[count++] = &opened.child(1);
    }
    const std::span<BinaryNode* const> chosen(children.data(), count);
    const std::size_t left = share(as_inner(root).child(0), chosen);
    as_inner(root).shares = {};
    as_inner(root).shares.set_own_from_left(left);
    share(as_inner(root).child(1), chosen);
    for (BinaryNode* const child : chosen) collapse(*child);
  }

  static float area_to_open(const BinaryNode& node) {
    return node.is_leaf() ? -1.0f : node.bounds().centre_area();
  }

  /// Of the children of a wide node, those that are `node` or below it; tells the nodes above them.
  static std::size_t share(BinaryNode& node, std::span<BinaryNode* const> chosen) {
    if (std::ranges::find(chosen, &node) != chosen.end()) return 1;
    if (node.is_leaf()) return 0;
    BinaryInner& inner = as_inner(node);
    const std::size_t left = share(inner.child(0), chosen);
    const std::size_t count = left + share(inner.child(1), chosen);
    inner.shares = {};
    inner.shares.set_from_left(count, left);
    return count;
  }
};

// Meshlets --------------------------------------------------------------------------------------------------

/// A meshlet for each triangle.
void make_triangles(BuildContext& context) {
  for (const BuildMesh& mesh : context.meshes) {
    MeshletSet& set = context.meshlets.emplace_back();
    std::vector<std::uint32_t> valid;
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
      if (mesh.is_valid(mesh.triangle(mesh.prim(i)))) valid.push_back(mesh.prim(i));
    }
    set.triangles = valid.size();
    set.invalid_triangles = mesh.triangle_count() - valid.size();
    if (valid.empty()) continue;
    set.storage = std::make_unique<TemporaryArray<Meshlet>>(context.memory, valid.size());
    for (std::size_t i = 0; i < valid.size(); ++i) {
      Meshlet& meshlet = set.storage->data()[i] = {};
      const TriangleIndices corners = mesh.triangle(valid[i]);
      meshlet.triangle_count = 1;
      meshlet.prims[0] = valid[i];
      for (std::uint8_t corner = 0; corner < 3; ++corner) {
        meshlet.corners[corner][0] = corner;
        meshlet.vertices[corner] = corners[corner];
      }
      meshlet.vertex_count = 3;
    }
  }
}

class NoMeshlets final : public TopDown {
 public:
  using TopDown::TopDown;

 private:
  bool is_leaf(const ReferenceSet& set) const override { return joined(set).has_value(); }

  void enter_leaf(const ReferenceSet& set, BinaryLeaf& leaf) override {
    TopDown::enter_leaf(set, leaf);
    if (set.size() == 1) return;
    Meshlet* const meshlet = arena().make<Meshlet>();
    *meshlet = *joined(set);
    leaf.meshlet = meshlet;
  }

  /// The triangles of a set as one leaf; none: they do not fit.
  std::optional<Meshlet> joined(const ReferenceSet& set) const {
    if (set.size() > kWidth) return std::nullopt;
    Meshlet all{};
    for (const Reference& reference : set.references) {
      if (reference.mesh != set.references[0].mesh) return std::nullopt;
      const Meshlet& one = meshlet(reference);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = one.vertices[one.corners[corner][0]];
        std::uint8_t slot = 0;
        while (slot < all.vertex_count && all.vertices[slot] != vertex) ++slot;
        if (slot == kWidth) return std::nullopt;
        if (slot == all.vertex_count) all.vertices[all.vertex_count++] = vertex;
        all.corners[corner][all.triangle_count] = slot;
      }
      all.prims[all.triangle_count++] = one.prims[0];
    }
    return all;
  }
};

// What makes them -------------------------------------------------------------------------------------------

template <typename Builder>
GalleryTree::Method ours() {
  GalleryTree::Method method;
  method.settings = {};
  method.make_builder = [](BuildContext& context) { return std::make_unique<Builder>(context); };
  return method;
}

template <typename Builder>
StructurePtr build_ours(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return std::make_unique<GalleryTree>(scene, ours<Builder>(), threads, progress);
}

}  // namespace

StructurePtr build_no_leaf_cost(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_ours<NoLeafCost>(scene, threads, progress);
}
StructurePtr build_no_temporal_first(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_ours<NoTemporalFirst>(scene, threads, progress);
}
StructurePtr build_no_tight_lines(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_ours<NoTightLines>(scene, threads, progress);
}
StructurePtr build_no_static_side(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_ours<NoStaticSide>(scene, threads, progress);
}
StructurePtr build_no_optimal_collapse(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_ours<NoOptimalCollapse>(scene, threads, progress);
}
StructurePtr build_no_meshlets(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  GalleryTree::Method method = ours<NoMeshlets>();
  method.prepare = make_triangles;
  return std::make_unique<GalleryTree>(scene, method, threads, progress);
}
StructurePtr build_no_step_reduction(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return build_in_own_nodes<TopDown>(scene, threads, progress);
}

}  // namespace stbvh::harness::gallery
