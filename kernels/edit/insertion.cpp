#include "edit/insertion.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "builder/mbsah.h"
#include "builder/merged_bounds.h"
#include "edit/tree_edit.h"

namespace stbvh {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

bool covers(const ClosedTimeRange& range, const ClosedTimeRange& other) {
  return range.begin <= other.begin && range.last >= other.last;
}

/// Linear bounds over `range` of two children.
LinearBounds joint_bounds(const NodeSlot& a, const NodeSlot& b, const ClosedTimeRange& range) {
  const TimedBounds children[] = {{a.bounds(), a.range}, {b.bounds(), b.range}};
  return merged_bounds(range, children);
}

double area_of(const NodeSlot& slot) {
  return expected_area(slot.bounds(), slot.range);
}

/// Occlusion rays try the children in their order: what is large comes first.
void add_sorted(NodeSlots& node, const NodeSlot& slot) {
  const double area = area_of(slot);
  std::size_t place = node.count++;
  for (; place > 0 && area_of(node.slots[place - 1]) < area; --place)
    node.slots[place] = node.slots[place - 1];
  node.slots[place] = slot;
}

std::size_t found(const std::optional<std::size_t>& place) {
  if (!place) throw BlockIsFull();
  return *place;
}

}  // namespace

std::vector<Insertion::Level> Insertion::way_to(const NodeSlot& subtree) const {
  std::vector<Level> way;
  std::size_t best_levels = 0;
  double best = kNever, growth = 0.0;  // of the boxes on the way
  NodeSlot at = root_;
  while (kind_of(at.link) != LinkKind::kLeaf && covers(at.range, subtree.range) && growth < best) {
    Level level{read_node(kind_of(at.link), data_ + unit_of(at.link) * kUnitBytes, at.range), at.link};
    double least = kNever, joint = kNever;
    for (std::size_t i = 0; i < level.node.count; ++i) {
      const NodeSlot& child = level.node.slots[i];
      if (!covers(child.range, subtree.range)) continue;
      const double area = expected_area(joint_bounds(child, subtree, child.range), child.range);
      if (area - area_of(child) >= least) continue;
      least = area - area_of(child);
      joint = area;
      level.chosen = i;
    }
    // With a place left it costs nothing but its own boxes; else a node for it and the child next to it.
    const double here = growth + (level.node.count < kWidth ? 0.0 : joint);
    at = level.node.slots[level.chosen];
    way.push_back(level);
    if (here < best) {
      best = here;
      best_levels = way.size();
    }
    if (least == kNever) break;
    growth += least;
  }
  way.resize(best_levels);
  return way;
}

NodeSlot Insertion::paired(const NodeSlot& a, const NodeSlot& b, const ClosedTimeRange& range) {
  NodeSlots node;
  node.range = range;
  add_sorted(node, a);
  add_sorted(node, b);
  const LinkKind kind = node.kind();
  const std::size_t place = found(space_.take(node_units(kind)));
  write_node(node, data_ + place * kUnitBytes);
  change_.add_node(kind, node.count);
  change_.expected_area += expected_area(node);
  return make_slot({bounds_of(node), range, make_link(kind, place)});
}

Link Insertion::replace(Link link, const NodeSlots& before, const NodeSlots& after) {
  const LinkKind kind = after.kind();
  const std::size_t place = found(space_.resized(unit_of(link), node_units(kind_of(link)), node_units(kind)));
  write_node(after, data_ + place * kUnitBytes);
  change_.add_node(kind_of(link), before.count, -1);
  change_.add_node(kind, after.count);
  change_.expected_area += expected_area(after) - expected_area(before);
  return make_link(kind, place);
}

void Insertion::insert(const NodeSlot& subtree) {
  std::vector<Level> way = way_to(subtree);
  levels_ = way.size();
  if (way.empty()) {
    const ClosedTimeRange range{std::min(root_.range.begin, subtree.range.begin),
                                std::max(root_.range.last, subtree.range.last)};
    root_ = paired(root_, subtree, range);
    pushes_down_ = true;
    return;
  }
  std::optional<NodeSlot> below;  // what the level under this one has become
  while (!way.empty()) {
    const Level& level = way.back();
    NodeSlots node = level.node;
    NodeSlot& chosen = node.slots[level.chosen];
    if (below) {
      chosen = *below;
    } else if (node.count < kWidth) {
      add_sorted(node, subtree);
    } else {
      chosen = paired(chosen, subtree, chosen.range);
      pushes_down_ = true;
    }
    const Link link = replace(level.link, level.node, node);
    below = make_slot({bounds_of(node), node.range, link});
    way.pop_back();
  }
  root_ = *below;
}

}  // namespace stbvh
