#include "edit/tree_edit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "builder/mbsah.h"
#include "builder/merged_bounds.h"
#include "builder/motion_bounds.h"
#include "layout/leaf_segment.h"
#include "layout/meshlet.h"

namespace stbvh {

/// Bounds of the children of a node, which take their time to be put together.
struct NodeChildren {
  std::array<TimedBounds, kWidth> bounds;
  std::size_t count = 0;

  NodeChildren() = default;
  explicit NodeChildren(const NodeSlots& node) {
    for (const NodeSlot& slot : node.used()) add(slot);
  }

  void add(const NodeSlot& slot) { bounds[count++] = {slot.bounds(), slot.range}; }
  std::span<const TimedBounds> used() const { return {bounds.data(), count}; }

  LinearBounds merged(const ClosedTimeRange& range) const { return merged_bounds(range, used()); }
  double expected_area() const {
    double area = 0.0;
    for (const auto& [of_child, range] : used()) area += stbvh::expected_area(of_child, range);
    return area;
  }
};

namespace {

constexpr std::size_t kParallelLevels = 4;  ///< nodes above visit their children at once
constexpr std::size_t kMostBoxes = 16;      ///< that each child is held against

bool overlaps(const Box4& a, const Box4& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.lower[axis] > b.upper[axis] || b.lower[axis] > a.upper[axis]) return false;
  }
  return true;
}

}  // namespace

LinearBounds bounds_of(const NodeSlots& node) {
  return NodeChildren(node).merged(node.range);
}

double expected_area(const NodeSlots& node) {
  return NodeChildren(node).expected_area();
}

TreeEdit::TreeEdit(std::byte* data, UnitSpace& space, const MeshRecord* table,
                   std::vector<RecordEdit> records, const BuildProgress& progress)
    : data_(data),
      space_(space),
      table_(table),
      records_(std::move(records)),
      progress_(progress),
      samples_(records_.size()),
      met_([this] { return Met{std::vector<Box4>(records_.size(), Box4::empty())}; }),
      bounds_(records_.size(), Box4::empty()),
      torn_(records_.size()) {
  for (const RecordEdit& record : records_) {
    if (record.fate == RecordEdit::Fate::kStays) continue;
    if (edited_.size() < kMostBoxes) {
      edited_.push_back(record.before);
    } else {
      edited_.back().extend(record.before);
    }
  }
}

TreeEdit::Outcome TreeEdit::apply(Link root, const ClosedTimeRange& range) {
  whole_ = range;
  for (std::size_t record = 0; record < records_.size(); ++record) {
    if (records_[record].fate == RecordEdit::Fate::kMoved)
      samples_[record].emplace(*records_[record].mesh, range);
  }
  Outcome outcome = visit(root, range, 0);
  for (const Met& met : met_) {
    for (std::size_t record = 0; record < records_.size(); ++record)
      bounds_[record].extend(met.bounds[record]);
    leaves_moved_ += met.leaves_moved;
  }
  return outcome;
}

std::vector<std::uint32_t> TreeEdit::torn_records() const {
  std::vector<std::uint32_t> result;
  for (std::uint32_t record = 0; record < torn_.size(); ++record) {
    if (torn_[record] != 0) result.push_back(record);
  }
  return result;
}

bool TreeEdit::may_hold_edits(const LinearBounds& bounds) const {
  const Box4 box = bounds.whole();
  return std::ranges::any_of(edited_, [&](const Box4& edited) { return overlaps(box, edited); });
}

TreeEdit::Outcome TreeEdit::visit(Link link, const ClosedTimeRange& range, std::size_t level) {
  return kind_of(link) == LinkKind::kLeaf ? visit_leaf(link, range) : visit_node(link, range, level);
}

LinearBounds TreeEdit::bounds_of_moved(const BuildMesh& mesh, std::uint32_t record,
                                       const ClosedTimeRange& range, const Meshlet& meshlet) const {
  if (range == whole_) return motion_bounds(mesh, *samples_[record], meshlet.used_vertices());
  return motion_bounds(mesh, MotionSamples(mesh, range), meshlet.used_vertices());
}

TreeEdit::Outcome TreeEdit::visit_leaf(Link link, const ClosedTimeRange& range) {
  std::byte* const data = data_ + unit_of(link) * kUnitBytes;
  LeafHeader leaf;
  std::memcpy(&leaf, data, sizeof leaf);
  const RecordEdit& record = records_[leaf.mesh];
  if (record.fate == RecordEdit::Fate::kStays) return {};
  Outcome outcome{.is_changed = true};
  const std::size_t steps = steps_of(leaf, table_[leaf.mesh], range);
  if (record.fate == RecordEdit::Fate::kRemoved) {
    outcome.is_gone = true;
    outcome.change.leaf_triangles = -std::int64_t{leaf.triangle_count};
    if (leaf.indexed != 0) {  // others may share it
      outcome.change.indexed_leaves = -1;
      return outcome;
    }
    const std::size_t units = inline_leaf_bytes(steps) / kUnitBytes;
    outcome.change.inline_leaves = -1;
    outcome.change.leaf_units = -static_cast<std::int64_t>(units);
    give_back(unit_of(link), units);
    return outcome;
  }
  const BuildMesh* const mesh = record.mesh;
  const std::optional<Meshlet> meshlet = read_meshlet(leaf, mesh->view());
  if (!meshlet) {
    const std::scoped_lock lock(mutex_);
    torn_[leaf.mesh] = 1;
    return {};
  }
  const LinearBounds bounds = bounds_of_moved(*mesh, leaf.mesh, range, *meshlet);
  if (leaf.indexed == 0) {
    write_inline_leaf(leaf.mesh, *meshlet, leaf.first_segment,
                      mesh->view().steps.subspan(leaf.first_segment, steps), data);
  }
  outcome.slot = make_slot({bounds, range, link});
  Met& met = met_.local();
  ++met.leaves_moved;
  met.bounds[leaf.mesh].extend(bounds.whole());
  return outcome;
}

TreeEdit::Outcome TreeEdit::visit_node(Link link, const ClosedTimeRange& range, std::size_t level) {
  progress_.check();
  NodeSlots node = read_node(kind_of(link), data_ + unit_of(link) * kUnitBytes, range);
  const NodeChildren children(node);
  std::array<Outcome, kWidth> outcomes;
  std::array<bool, kWidth> visited{};
  for (std::size_t i = 0; i < node.count; ++i) visited[i] = may_hold_edits(children.bounds[i].bounds);
  const auto visit_child = [&](std::size_t i) {
    if (visited[i]) outcomes[i] = visit(node.slots[i].link, node.slots[i].range, level + 1);
  };
  if (level < kParallelLevels) {
    tbb::parallel_for(std::size_t{0}, node.count, visit_child);
  } else {
    for (std::size_t i = 0; i < node.count; ++i) visit_child(i);
  }
  NodeSlots edited;
  edited.range = range;
  NodeChildren edited_children;
  TreeCounts change;
  bool is_changed = false;
  for (std::size_t i = 0; i < node.count; ++i) {
    const Outcome& outcome = outcomes[i];
    is_changed = is_changed || outcome.is_changed;
    change.add(outcome.change);
    if (outcome.is_gone) continue;
    edited.slots[edited.count++] = outcome.is_changed ? outcome.slot : node.slots[i];
    if (outcome.is_changed) {
      edited_children.add(outcome.slot);
    } else {
      edited_children.bounds[edited_children.count++] = children.bounds[i];
    }
  }
  if (!is_changed) return {};
  change.expected_area -= children.expected_area();
  return rewritten(link, node, edited, edited_children, change);
}

TreeEdit::Outcome TreeEdit::rewritten(Link link, const NodeSlots& before, const NodeSlots& after,
                                      const NodeChildren& children, TreeCounts change) {
  const std::size_t unit = unit_of(link), units = node_units(kind_of(link));
  Outcome outcome{.is_changed = true, .change = change};
  outcome.change.add_node(kind_of(link), before.count, -1);
  if (after.count <= 1) {  // the child takes the node's place
    give_back(unit, units);
    outcome.is_gone = after.count == 0;
    if (after.count == 1) outcome.slot = after.slots[0];
    return outcome;
  }
  const LinkKind kind = after.kind();
  outcome.change.add_node(kind, after.count);
  outcome.change.expected_area += children.expected_area();
  const std::size_t needed = node_units(kind);
  std::size_t place = unit;
  if (needed != units) {
    const std::scoped_lock lock(mutex_);
    const std::optional<std::size_t> found = space_.resized(unit, units, needed);
    if (!found) throw BlockIsFull();
    place = *found;
  }
  write_node(after, data_ + place * kUnitBytes);
  outcome.slot = make_slot({children.merged(after.range), after.range, make_link(kind, place)});
  return outcome;
}

void TreeEdit::give_back(std::size_t unit, std::size_t units) {
  const std::scoped_lock lock(mutex_);
  space_.give_back(unit, units);
}

}  // namespace stbvh
