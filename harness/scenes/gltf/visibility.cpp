#include "harness/scenes/gltf/visibility.h"

#include <algorithm>
#include <span>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

using Intervals = std::vector<Interval>;

/// As a share of the shutter: what is there for less is left out, as no structure can divide it into steps.
constexpr double kShortestVisible = 1e-6;

/// Of all that a file may need, what these intervals may: in nodes with geometry, they are a small part of
/// it.
constexpr double kLargestShare = 1.0 / 16;

/// What a channel alone shows.
Intervals shown_by(const Channel* channel, const Timeline& timeline) {
  std::vector<double> bounds = timeline.key_fractions({&channel, 1});
  bounds.push_back(1);
  Intervals intervals;
  double begin = 0;
  for (const double end : bounds) {
    double visible = 1;
    channel->evaluate(timeline.clip_time((begin + end) / 2), Side::kAfter, {&visible, 1});
    if (visible != 0) {
      if (!intervals.empty() && intervals.back().end == begin) {
        intervals.back().end = end;
      } else {
        intervals.push_back({begin, end});
      }
    }
    begin = end;
  }
  return intervals;
}

/// What is in both.
Intervals overlap(const Intervals& a, const Intervals& b) {
  Intervals both;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    const Interval common{std::max(i->begin, j->begin), std::min(i->end, j->end)};
    if (common.end - common.begin >= kShortestVisible) both.push_back(common);
    if (i->end < j->end) {
      ++i;
    } else {
      ++j;
    }
  }
  return both;
}

/// The channel that has the last word on whether its node is visible, or null.
const Channel* visibility_channel(std::span<const Channel* const> channels) {
  const auto found = std::find_if(channels.rbegin(), channels.rend(), [](const Channel* channel) {
    return channel->target.property == AnimatedProperty::kVisibility;
  });
  return found == channels.rend() ? nullptr : *found;
}

}  // namespace

Visibility::Visibility(const Model& model, const NodeTree& tree, const Timeline& timeline, double most_bytes)
    : intervals_(model.nodes.size()) {
  const auto always = std::make_shared<const Intervals>(1), never = std::make_shared<const Intervals>();
  double bytes = 0;
  for (const std::size_t node : tree.parents_first()) {
    check_cancelled();
    const std::size_t parent = tree.parent(node);
    const auto& above = parent == NodeTree::kNoParent ? always : intervals_[parent];
    const Channel* channel = visibility_channel(timeline.rig().channels_of(node));
    if (channel == nullptr) {
      intervals_[node] = model.nodes[node].is_visible ? above : never;
      continue;
    }
    auto both = std::make_shared<const Intervals>(overlap(*above, shown_by(channel, timeline)));
    bytes += static_cast<double>(both->size() * sizeof(Interval));
    if (bytes > kLargestShare * most_bytes)
      fail("its nodes are shown and hidden more often than a file of its size may");
    intervals_[node] = std::move(both);
  }
}

}  // namespace stbvh::harness::gltf
