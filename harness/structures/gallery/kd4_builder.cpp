#include "harness/structures/gallery/kd4_builder.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "builder/motion_bounds.h"
#include "builder/sample_array.h"
#include "harness/structures/gallery/boxes.h"

namespace stbvh::harness::gallery {
namespace {

/// Costs of a step of the traversal, and of testing a meshlet, which takes some twenty times as long. Trees
/// are all but the same with 8 and with 50: the limit of references ends most splitting.
constexpr double kStepCost = 1.0;
constexpr double kTestCost = 20.0;
/// A split that leaves one side empty costs this share of what it would.
constexpr double kEmptyShare = 0.8;
/// Splits in a row that do not pay by themselves, in the hope of one below that does.
constexpr std::size_t kMostBadSplits = 3;
/// References of all cells together: so many, but at least and at most so many for each meshlet.
constexpr double kMostReferences = 1e7;
constexpr double kLeastForMeshlet = 16.0;
constexpr double kMostForMeshlet = 200.0;
/// Nodes above a cell: so many more than halving takes.
constexpr double kMoreLevels = 20.0;

constexpr std::size_t kBins = 32;
constexpr std::size_t kSweptReferences = 48;       ///< up to so many all planes are tried
constexpr std::size_t kSampledReferences = 64;     ///< that splits in time are judged by
constexpr std::size_t kParallelReferences = 2048;  ///< sets from this size on are tasks of their own

/// Half the surface area.
double area(const Box4& box) {
  const F32x4 size4 = box.upper - box.lower;
  const double x = size4[0], y = size4[1], z = size4[2];
  return x * y + y * z + z * x;
}

Box4 clipped(const Box4& box, const Box4& to) {
  return {max(box.lower, to.lower), min(box.upper, to.upper)};
}

void set_lane(F32x4& v, std::size_t lane, float value) {
  alignas(16) float lanes[4];
  _mm_store_ps(lanes, v.v);
  lanes[lane] = value;
  v = F32x4(_mm_load_ps(lanes));
}

Box4 below(Box4 cell, std::size_t axis, float plane) {
  set_lane(cell.upper, axis, plane);
  return cell;
}
Box4 above(Box4 cell, std::size_t axis, float plane) {
  set_lane(cell.lower, axis, plane);
  return cell;
}

}  // namespace

/// The box of a meshlet over the time range of a cell, clipped to it.
struct KdBuilder::Reference {
  float lower[3];
  std::uint32_t mesh;
  float upper[3];
  std::uint32_t meshlet;

  Reference() = default;
  Reference(const Box4& box, std::uint32_t of_mesh, std::uint32_t number) {
    _mm_storeu_ps(lower, box.lower.v);
    _mm_storeu_ps(upper, box.upper.v);
    mesh = of_mesh;
    meshlet = number;
  }

  // What touches the plane alone is on one side: rays within its slack visit both.
  bool is_below(std::size_t axis, float plane) const {
    return lower[axis] < plane || (lower[axis] == plane && upper[axis] == plane);
  }
  bool is_above(std::size_t axis, float plane) const { return upper[axis] > plane; }
};

class KdBuilder::References {
 public:
  References(BuildMemory& memory, std::size_t most) : storage_(memory, most) {}

  void add(const Reference& reference) { storage_.data()[count_++] = reference; }
  std::span<const Reference> span() const { return {const_cast<References*>(this)->storage_.data(), count_}; }

 private:
  TemporaryArray<Reference> storage_;
  std::size_t count_ = 0;
};

/// What becomes a node.
struct KdBuilder::Task {
  KdCell cell;
  References references;
  double most_references;  ///< of the cells of its subtree
  double share;            ///< of all work
  std::size_t levels;      ///< that it may be split
  std::size_t bad_splits;  ///< in a row above it

  std::size_t size() const { return references.span().size(); }
};

struct KdBuilder::Split {
  double cost = std::numeric_limits<double>::infinity();  ///< of a cell that every ray meets
  KdAxis axis = KdAxis::kCell;
  float position = 0.0f;
};

/// Nodes and meshlets by their place in these vectors, the root first; or a root with two subtrees.
struct KdBuilder::Subtree {
  std::vector<KdNode> nodes;
  std::vector<std::uint32_t> meshlets;
  Split split;
  std::array<std::unique_ptr<Subtree>, 2> children;
};

/// Boxes of meshlets over one time range, from those at the steps: motion is linear in between, so that the
/// box between two steps lies in that between their boxes. Rounding is padded for at the steps.
class KdBuilder::BoxesOver {
 public:
  BoxesOver(const KdBuilder& builder, const ClosedTimeRange& range) : builder_(builder), range_(range) {}

  /// False: it is not alive then.
  bool make(std::uint32_t mesh, std::uint32_t number, Box4& out) {
    if (mesh != mesh_) enter(mesh);
    if (!is_alive_) return false;
    const std::size_t meshlet = number - builder_.first_number_[mesh];
    const Box4* const boxes = builder_.step_boxes_[mesh]->data() + meshlet * steps_;
    if (steps_ == 1) {
      out = boxes[0];
      return true;
    }
    out = united(at(boxes, first_), at(boxes, last_));
    for (std::uint32_t step = first_.segment + 1; step <= last_.segment; ++step) out.extend(boxes[step]);
    return true;
  }

 private:
  static Box4 at(const Box4* boxes, const SegmentTime& time) {
    const Box4 &begin = boxes[time.segment], &end = boxes[time.segment + 1];
    const F32x4 f0(1.0f - time.fraction), f1(time.fraction);
    return {f0 * begin.lower + f1 * end.lower, f0 * begin.upper + f1 * end.upper};
  }

  void enter(std::uint32_t number) {
    const BuildMesh& mesh = builder_.context_.meshes[number];
    mesh_ = number;
    steps_ = mesh.view().steps.size();
    const ClosedTimeRange alive = mesh.alive(range_);
    is_alive_ = alive.begin <= alive.last;
    if (!is_alive_ || mesh.is_static()) return;
    first_ = mesh.segment_at(alive.begin);
    last_ = mesh.segment_at(alive.last);
  }

  const KdBuilder& builder_;
  ClosedTimeRange range_;
  std::uint32_t mesh_ = 0xFFFFFFFFu;  ///< the last one asked for
  bool is_alive_ = false;
  std::size_t steps_ = 0;
  SegmentTime first_{}, last_{};
};

KdBuilder::KdBuilder(BuildContext& context) : context_(context) {}
KdBuilder::~KdBuilder() = default;

void KdBuilder::make_step_boxes() {
  for (std::size_t i = 0; i < context_.meshes.size(); ++i) {
    const BuildMesh& mesh = context_.meshes[i];
    const std::span<const Meshlet> meshlets = context_.meshlets[i].meshlets();
    const std::size_t steps = mesh.view().steps.size();
    const MotionSamples samples(mesh, {mesh.grid().begin, mesh.grid().end});  // exactly the steps
    auto& boxes = step_boxes_.emplace_back(
        std::make_unique<TemporaryArray<Box4>>(context_.memory, meshlets.size() * steps));
    context_.progress.poll();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, meshlets.size(), 256), [&](const auto& part) {
      SampleArray<BoundsSample> sampled(steps);
      const std::span<BoundsSample> at_steps(sampled.data(), steps);
      for (std::size_t m = part.begin(); m != part.end(); ++m) {
        sample_boxes(mesh, samples, meshlets[m].used_vertices(), at_steps);
        for (std::size_t step = 0; step < steps; ++step) boxes->data()[m * steps + step] = at_steps[step].box;
      }
    });
  }
}

std::unique_ptr<KdBuilder::Task> KdBuilder::whole_task() {
  std::size_t meshlets = 0;
  std::size_t most_segments = 1;
  for (std::size_t i = 0; i < context_.meshes.size(); ++i) {
    const BuildMesh& mesh = context_.meshes[i];
    const std::size_t count = context_.meshlets[i].meshlets().size();
    first_number_.push_back(meshlets);
    meshlets += count;
    const ClosedTimeRange alive = mesh.alive({0.0f, 1.0f});
    if (count == 0 || !(alive.begin <= alive.last)) continue;
    all_.range = {std::min(all_.range.begin, alive.begin), std::max(all_.range.last, alive.last)};
    most_segments = std::max(most_segments, mesh.segments());
  }
  if (!(all_.range.begin <= all_.range.last)) return nullptr;
  make_step_boxes();
  auto task = std::unique_ptr<Task>(new Task{{}, {context_.memory, meshlets}, 0, 1.0, 0, 0});
  BoxesOver boxes(*this, all_.range);
  for (std::uint32_t i = 0; i < context_.meshes.size(); ++i) {
    const std::size_t count = context_.meshlets[i].meshlets().size();
    for (std::size_t m = 0; m < count; ++m) {
      const auto number = static_cast<std::uint32_t>(first_number_[i] + m);
      Box4 box;
      if (!boxes.make(i, number, box)) break;
      task->references.add({box, i, number});
      all_.box.extend(box);
    }
  }
  task->cell = all_;
  const auto size = static_cast<double>(task->size());
  task->most_references = std::clamp(kMostReferences, kLeastForMeshlet * size, kMostForMeshlet * size);
  const double levels = kMoreLevels + 1.3 * std::log2(size) + std::log2(static_cast<double>(most_segments));
  task->levels = std::min(static_cast<std::size_t>(levels), kMostKdLevels);
  return task;
}

bool KdBuilder::build() {
  std::unique_ptr<Task> task = whole_task();
  if (task == nullptr) return false;
  root_ = build_subtree(std::move(task));
  step_boxes_.clear();
  count(*root_);
  node_count_ += 1;
  counted_ = std::make_unique<CountedMemory>(
      context_.memory, node_count_ * sizeof(KdNode) + link_count_ * sizeof(std::uint32_t));
  if (std::max(node_count_, link_count_) > KdNode::kMostPlaces)
    throw std::length_error("more nodes or references than a kd-tree can have");
  return true;
}

// Where to split ------------------------------------------------------------------------------------------

namespace {

/// What a split costs whose sides a ray meets with these chances.
double split_cost(double below, double count_below, double above, double count_above) {
  const double tests = kTestCost * (below * count_below + above * count_above);
  return kStepCost + (count_below == 0 || count_above == 0 ? kEmptyShare : 1.0) * tests;
}

}  // namespace

/// The planes across one axis of a cell.
class KdBuilder::Planes {
 public:
  Planes(const Task& task, std::size_t axis, Split& best)
      : references_(task.references.span()), axis_(axis), best_(best) {
    const Box4& cell = task.cell.box;
    const int lane = static_cast<int>(axis);
    const F32x4 size4 = cell.upper - cell.lower;
    const double u = size4[(lane + 1) % 3], v = size4[(lane + 2) % 3];
    lower_ = cell.lower[lane];
    upper_ = cell.upper[lane];
    face_ = u * v / area(cell);
    rim_ = (u + v) / area(cell);
  }

  void try_some() {
    if (!(lower_ < upper_) || !std::isfinite(face_ + rim_)) return;
    references_.size() <= kSweptReferences ? try_faces() : try_bins();
  }

 private:
  void consider(float plane, std::size_t count_below, std::size_t count_above) {
    if (!(plane > lower_ && plane < upper_)) return;
    const double below = face_ + rim_ * (static_cast<double>(plane) - lower_);
    const double above = face_ + rim_ * (static_cast<double>(upper_) - plane);
    const double cost =
        split_cost(below, static_cast<double>(count_below), above, static_cast<double>(count_above));
    if (cost < best_.cost) best_ = {cost, static_cast<KdAxis>(axis_), plane};
  }

  /// At each face of a box: what begins before it is below, what ends behind it is above.
  void try_faces() {
    const std::size_t n = references_.size();
    std::array<float, kSweptReferences> lowers, uppers;
    for (std::size_t i = 0; i < n; ++i) {
      lowers[i] = references_[i].lower[axis_];
      uppers[i] = references_[i].upper[axis_];
    }
    std::sort(lowers.begin(), lowers.begin() + static_cast<std::ptrdiff_t>(n));
    std::sort(uppers.begin(), uppers.begin() + static_cast<std::ptrdiff_t>(n));
    for (std::size_t i = 0, ended = 0; i < n; ++i) {
      while (ended < n && uppers[ended] <= lowers[i]) ++ended;
      if (i == 0 || lowers[i] > lowers[i - 1]) consider(lowers[i], i, n - ended);
    }
    for (std::size_t i = 0, begun = 0; i < n; ++i) {
      while (begun < n && lowers[begun] < uppers[i]) ++begun;
      if (i + 1 == n || uppers[i] < uppers[i + 1]) consider(uppers[i], begun, n - i - 1);
    }
  }

  void try_bins() {
    const float width = (upper_ - lower_) / static_cast<float>(kBins);
    const float per_width = 1.0f / width;
    if (!std::isfinite(per_width)) return;
    const auto bin_of = [&](float x) {
      const float bin = (x - lower_) * per_width;
      return std::min(bin > 0.0f ? static_cast<std::size_t>(bin) : 0, kBins - 1);
    };
    std::array<std::size_t, kBins> begin{}, end{};
    for (const Reference& reference : references_) {
      ++begin[bin_of(reference.lower[axis_])];
      ++end[bin_of(reference.upper[axis_])];
    }
    for (std::size_t bin = 1, begun = 0, ended = 0; bin < kBins; ++bin) {
      begun += begin[bin - 1];
      ended += end[bin - 1];
      consider(lower_ + static_cast<float>(bin) * width, begun, references_.size() - ended);
    }
  }

  std::span<const Reference> references_;
  std::size_t axis_;
  Split& best_;
  float lower_, upper_;  ///< of the cell
  double face_, rim_;    ///< shares of its surface: one side across the axis; those along it, for each unit
};

void KdBuilder::try_time(const Task& task, Split& best) const {
  const ClosedTimeRange& range = task.cell.range;
  const std::span<const Reference> references = task.references.span();
  const float centre = 0.5f * range.begin + 0.5f * range.last;
  // On threads that flush denormal numbers those are 0: no boundary lies among them.
  if (!(centre > range.begin && centre >= std::numeric_limits<float>::min())) return;
  const double share = (static_cast<double>(centre) - range.begin) / range.length();
  const std::size_t sampled = std::min(references.size(), kSampledReferences);
  std::array<double, 2> counts{};
  const auto halves = halves_at(range, centre);
  for (std::size_t half = 0; half < 2; ++half) {
    BoxesOver boxes(*this, halves[half]);
    for (std::size_t i = 0; i < sampled; ++i) {
      const Reference& reference = references[i * references.size() / sampled];
      Box4 box;
      counts[half] +=
          boxes.make(reference.mesh, reference.meshlet, box) && overlap(box, task.cell.box) ? 1.0 : 0.0;
    }
    counts[half] *= static_cast<double>(references.size()) / static_cast<double>(sampled);
  }
  const double cost = split_cost(share, counts[0], 1.0 - share, counts[1]);
  if (cost < best.cost) best = {cost, KdAxis::kTime, centre};
}

KdBuilder::Split KdBuilder::find_split(const Task& task) const {
  Split best;
  for (std::size_t axis = 0; axis < 3; ++axis) Planes(task, axis, best).try_some();
  const auto moves = [&](const Reference& reference) { return !context_.meshes[reference.mesh].is_static(); };
  if (std::ranges::any_of(task.references.span(), moves)) try_time(task, best);
  return best;
}

std::unique_ptr<KdBuilder::Task> KdBuilder::new_side(const Task& whole, const KdCell& cell,
                                                     std::size_t most) const {
  return std::unique_ptr<Task>(
      new Task{cell, {context_.memory, most}, 0.0, whole.share / 2, whole.levels - 1, 0});
}

KdBuilder::Sides KdBuilder::sides_in_time(const Task& task, float boundary) const {
  Sides sides;
  const auto halves = halves_at(task.cell.range, boundary);
  for (std::size_t half = 0; half < 2; ++half) {
    sides[half] = new_side(task, {task.cell.box, halves[half]}, task.size());
    BoxesOver boxes(*this, halves[half]);
    for (const Reference& reference : task.references.span()) {
      Box4 box;
      if (!boxes.make(reference.mesh, reference.meshlet, box) || !overlap(box, task.cell.box)) continue;
      sides[half]->references.add({clipped(box, task.cell.box), reference.mesh, reference.meshlet});
    }
  }
  return sides;
}

KdBuilder::Sides KdBuilder::sides_in_space(const Task& task, std::size_t axis, float plane) const {
  const std::span<const Reference> references = task.references.span();
  std::array<std::size_t, 2> counts{};
  for (const Reference& reference : references) {
    counts[0] += reference.is_below(axis, plane);
    counts[1] += reference.is_above(axis, plane);
  }
  Sides sides{new_side(task, {below(task.cell.box, axis, plane), task.cell.range}, counts[0]),
              new_side(task, {above(task.cell.box, axis, plane), task.cell.range}, counts[1])};
  for (const Reference& reference : references) {
    Reference part = reference;
    part.upper[axis] = std::min(part.upper[axis], plane);
    if (reference.is_below(axis, plane)) sides[0]->references.add(part);
    part = reference;
    part.lower[axis] = std::max(part.lower[axis], plane);
    if (reference.is_above(axis, plane)) sides[1]->references.add(part);
  }
  return sides;
}

std::optional<KdBuilder::Sides> KdBuilder::split(std::unique_ptr<Task>& task, Split& split) const {
  if (task->levels == 0 || task->size() < 2) return std::nullopt;
  split = find_split(*task);
  if (split.axis == KdAxis::kCell) return std::nullopt;
  const bool pays = split.cost < kTestCost * static_cast<double>(task->size());
  const std::size_t bad_splits = pays ? 0 : task->bad_splits + 1;
  if (bad_splits > kMostBadSplits) return std::nullopt;
  Sides sides = split.axis == KdAxis::kTime
                    ? sides_in_time(*task, split.position)
                    : sides_in_space(*task, static_cast<std::size_t>(split.axis), split.position);
  const auto both = static_cast<double>(sides[0]->size() + sides[1]->size());
  if (both > task->most_references) return std::nullopt;
  for (auto& side : sides) {
    side->bad_splits = bad_splits;
    if (both > 0) side->most_references = task->most_references * static_cast<double>(side->size()) / both;
  }
  task.reset();
  return sides;
}

// The tree ------------------------------------------------------------------------------------------------

std::unique_ptr<KdBuilder::Subtree> KdBuilder::build_subtree(std::unique_ptr<Task> task) {
  auto subtree = std::make_unique<Subtree>();
  if (task->size() >= kParallelReferences) {
    if (auto sides = split(task, subtree->split)) {
      tbb::parallel_invoke([&] { subtree->children[0] = build_subtree(std::move((*sides)[0])); },
                           [&] { subtree->children[1] = build_subtree(std::move((*sides)[1])); });
      return subtree;
    }
  }
  const double share = task->share;
  subtree->nodes.resize(1);
  build_node(std::move(task), 0, *subtree);
  context_.progress.add(share);
  return subtree;
}

void KdBuilder::build_node(std::unique_ptr<Task> task, std::size_t node, Subtree& out) const {
  context_.progress.check();
  Split chosen;
  auto sides = split(task, chosen);
  if (!sides) {
    out.nodes[node] = KdNode::cell(out.meshlets.size(), task->size());
    for (const Reference& reference : task->references.span()) out.meshlets.push_back(reference.meshlet);
    return;
  }
  const std::size_t first = out.nodes.size();
  out.nodes[node] = KdNode::inner(chosen.axis, chosen.position, first);
  out.nodes.resize(first + 2);
  for (std::size_t side = 0; side < 2; ++side) build_node(std::move((*sides)[side]), first + side, out);
}

void KdBuilder::count(const Subtree& subtree) {
  if (subtree.children[0] != nullptr) {
    node_count_ += 2;
    for (const auto& child : subtree.children) count(*child);
    return;
  }
  node_count_ += subtree.nodes.size() - 1;
  link_count_ += subtree.meshlets.size();
}

void KdBuilder::write(std::span<const Link> leaves, KdNode* nodes, Link* links) const {
  std::size_t next_node = 1, next_link = 0;
  const auto place = [&](const auto& self, const Subtree& subtree, std::size_t place_of_root) -> void {
    if (subtree.children[0] != nullptr) {
      const std::size_t first = next_node;
      next_node += 2;
      nodes[place_of_root] = KdNode::inner(subtree.split.axis, subtree.split.position, first);
      for (std::size_t side = 0; side < 2; ++side) self(self, *subtree.children[side], first + side);
      return;
    }
    for (std::size_t i = 0; i < subtree.nodes.size(); ++i) {
      const KdNode& node = subtree.nodes[i];
      nodes[i == 0 ? place_of_root : next_node + i - 1] =
          node.moved(node.axis() == KdAxis::kCell ? next_link : next_node - 1);
    }
    for (const std::uint32_t meshlet : subtree.meshlets) links[next_link++] = leaves[meshlet];
    next_node += subtree.nodes.size() - 1;
  };
  place(place, *root_, 0);
}

}  // namespace stbvh::harness::gallery
