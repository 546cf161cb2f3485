/// The parts that updates are made of: nodes taken apart, room in a block.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <optional>
#include <vector>

#include "edit/unit_space.h"
#include "layout/node_slots.h"
#include "tests/random.h"

namespace stbvh {
namespace {

using test::Random;

NodePlan random_plan(Random& random, LinkKind kind) {
  NodePlan plan;
  plan.range = {0.25f, 0.75f};
  plan.count = 1 + static_cast<std::size_t>(random.unit() * 7.99f);
  for (std::size_t i = 0; i < plan.count; ++i) {
    const auto point = [&] { return F32x4(random.unit(), 10 * random.unit(), 100 * random.unit()); };
    NodePlan::Child& child = plan.children[i];
    const F32x4 size(0.5f);
    const F32x4 begin = point();
    child.bounds.begin = {begin, begin + size};
    const F32x4 end = kind == LinkKind::kStaticNode ? begin : point();
    child.bounds.end = {end, end + size};
    child.range = plan.range;
    if (kind == LinkKind::kSpatialTemporalNode) child.range.last = 0.25f + 0.4f * random.unit();
    child.link = static_cast<Link>(1000 * random.unit());
  }
  return plan;
}

TEST(NodeSlots, PutTogetherAgainAreTheSameBits) {
  Random random(1);
  for (const LinkKind kind : {LinkKind::kStaticNode, LinkKind::kLinearNode, LinkKind::kSpatialTemporalNode}) {
    for (int i = 0; i < 100; ++i) {
      const NodePlan plan = random_plan(random, kind);
      ASSERT_EQ(plan.kind(), kind);
      std::vector<std::byte> written(sizeof(SpatialTemporalNode)), again(written.size());
      write_node(plan, written.data());
      const NodeSlots node = read_node(kind, written.data(), plan.range);
      ASSERT_EQ(node.kind(), kind);
      ASSERT_EQ(node.count, plan.count);
      write_node(node, again.data());
      EXPECT_EQ(std::memcmp(written.data(), again.data(), node_units(kind) * kUnitBytes), 0);
      for (std::size_t k = 0; k < plan.count; ++k) {
        const NodeSlot made = make_slot(plan.children[k]);
        EXPECT_EQ(made.planes, node.slots[k].planes);
        EXPECT_EQ(made.slopes, node.slots[k].slopes);
        const LinearBounds bounds = node.slots[k].bounds();
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_LE(bounds.begin.lower[axis], plan.children[k].bounds.begin.lower[axis]);
          EXPECT_LE(bounds.end.lower[axis], plan.children[k].bounds.end.lower[axis]);
          EXPECT_GE(bounds.begin.upper[axis], plan.children[k].bounds.begin.upper[axis]);
          EXPECT_GE(bounds.end.upper[axis], plan.children[k].bounds.end.upper[axis]);
        }
      }
    }
  }
}

TEST(UnitSpace, HandsOutWhatNobodyHas) {
  Random random(2);
  UnitSpace space(100, 1000);
  std::map<std::size_t, std::size_t> taken{{0, 100}};
  std::size_t refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    if (random.unit() < 0.5f && !taken.empty()) {
      auto range = taken.begin();
      std::advance(range,
                   static_cast<std::ptrdiff_t>(random.unit() * 0.999f * static_cast<float>(taken.size())));
      space.give_back(range->first, range->second);
      taken.erase(range);
    } else {
      const std::size_t units = 1 + static_cast<std::size_t>(random.unit() * 40);
      const std::optional<std::size_t> first = space.take(units);
      if (!first) {
        ++refused;
        continue;
      }
      ASSERT_LE(*first + units, space.end());
      ASSERT_LE(space.end(), space.capacity());
      const auto next = taken.lower_bound(*first);
      if (next != taken.end()) {
        ASSERT_LE(*first + units, next->first);
      }
      if (next != taken.begin()) {
        ASSERT_LE(std::prev(next)->first + std::prev(next)->second, *first);
      }
      taken.emplace(*first, units);
    }
    std::size_t used = 0;
    for (const auto& [first, units] : taken) used += units;
    ASSERT_EQ(used + space.unused(), space.end());
  }
  EXPECT_GT(refused, 0u);
  for (const auto& [first, units] : taken) space.give_back(first, units);
  EXPECT_EQ(space.end(), 0u);
  EXPECT_EQ(space.unused(), 0u);
  EXPECT_EQ(space.take(1000), 0u);
}

}  // namespace
}  // namespace stbvh
