#include "stbvh/node_visitor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "limited.h"
#include "test_meshes.h"

namespace stbvh::test {
namespace {

struct KeptNode {
  TreeNode node;
  std::vector<std::uint32_t> prims;
  std::vector<std::size_t> children;
};

/// Keeps all nodes down to a level, each with its children.
class Keeper final : public NodeVisitor {
 public:
  explicit Keeper(std::size_t levels = 1000) : levels_(levels) {}

  bool enter(const TreeNode& node) override {
    if (!path.empty()) nodes[path.back()].children.push_back(nodes.size());
    EXPECT_EQ(node.level, path.size());
    if (node.level + 1 >= levels_) {
      nodes.push_back({node, {node.prim_ids.begin(), node.prim_ids.end()}, {}});
      return false;
    }
    path.push_back(nodes.size());
    nodes.push_back({node, {node.prim_ids.begin(), node.prim_ids.end()}, {}});
    return true;
  }
  void leave(const TreeNode& node) override {
    EXPECT_EQ(nodes[path.back()].node.level, node.level);
    path.pop_back();
  }

  std::vector<KeptNode> nodes;
  std::vector<std::size_t> path;

 private:
  std::size_t levels_;
};

/// In double: position_at of the contract, p = (1-f) p_k + f p_{k+1}.
std::array<double, 3> vertex_at(const TestMesh& mesh, std::uint32_t vertex, double time) {
  const std::size_t segments = mesh.positions.size() - 1;
  const auto position = [&](std::size_t step) {
    const Vec3f p = mesh.positions[step][vertex];
    return std::array<double, 3>{p.x, p.y, p.z};
  };
  if (segments == 0) return position(0);
  const double length = static_cast<double>(mesh.time_range.end) - mesh.time_range.begin;
  const double u = (time - mesh.time_range.begin) / length * static_cast<double>(segments);
  const auto k = std::min(static_cast<std::size_t>(u), segments - 1);
  const double f = u - static_cast<double>(k);
  const auto a = position(k), b = position(k + 1);
  return {(1 - f) * a[0] + f * b[0], (1 - f) * a[1] + f * b[1], (1 - f) * a[2] + f * b[2]};
}

bool contains(const Box3f& box, const std::array<double, 3>& p) {
  return box.lower.x <= p[0] && p[0] <= box.upper.x && box.lower.y <= p[1] && p[1] <= box.upper.y &&
         box.lower.z <= p[2] && p[2] <= box.upper.z;
}

/// Times inside a closed range: its ends, and some between.
std::vector<float> times_in(TimeRange range) {
  std::vector<float> times{range.begin, range.end};
  for (float f : {0.1f, 0.37f, 0.5f, 0.81f}) times.push_back(range.begin + f * (range.end - range.begin));
  return times;
}

class NodeVisitorTest : public testing::Test {
 protected:
  void build(std::vector<TestMesh> given, float share = 1.0f) {
    meshes = std::move(given);
    std::vector<MeshView> views;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      meshes[i].geom_id = static_cast<std::uint32_t>(10 + i);
      views.push_back(meshes[i].view());
    }
    structure = Structure::build(views, limited(views, share));
    structure->visit_nodes(keeper);
  }

  /// Every box on the way to a leaf holds the leaf's triangles at every time at which rays come there.
  void check_boxes(std::size_t index, std::vector<std::size_t> path) {
    path.push_back(index);
    const KeptNode& kept = keeper.nodes[index];
    for (std::size_t child : kept.children) check_boxes(child, path);
    if (!is_leaf(kept.node.kind)) return;
    const TestMesh& mesh = meshes[kept.node.geom_id - 10];
    for (float time : times_in(kept.node.time_range)) {
      if (time < mesh.time_range.begin || time > mesh.time_range.end) continue;
      for (std::uint32_t prim : kept.prims) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
          const auto p = vertex_at(mesh, mesh.indices[3 * prim + corner], time);
          for (std::size_t above : path) {
            ASSERT_TRUE(contains(keeper.nodes[above].node.box.at(time), p))
                << "prim " << prim << " at " << time << " in node " << above;
          }
        }
      }
    }
  }

  /// For each triangle, the time ranges of its leaves, sorted: they cover `whole` without overlap.
  void check_coverage(std::size_t mesh_index) {
    std::map<std::uint32_t, std::vector<TimeRange>> ranges;
    for (const KeptNode& kept : keeper.nodes) {
      if (!is_leaf(kept.node.kind) || kept.node.geom_id != 10 + mesh_index) continue;
      for (std::uint32_t prim : kept.prims) ranges[prim].push_back(kept.node.time_range);
    }
    const TestMesh& mesh = meshes[mesh_index];
    const bool is_static = mesh.positions.size() == 1;
    const TimeRange whole = is_static ? TimeRange{0, 1} : mesh.time_range;
    ASSERT_EQ(ranges.size(), mesh.indices.size() / 3);
    for (auto& [prim, r] : ranges) {
      std::sort(r.begin(), r.end(), [](TimeRange a, TimeRange b) { return a.begin < b.begin; });
      EXPECT_LE(r.front().begin, std::max(whole.begin, 0.0f));
      EXPECT_GE(r.back().end, std::min(whole.end, 1.0f));
      for (std::size_t i = 1; i < r.size(); ++i)
        ASSERT_EQ(std::nextafter(r[i - 1].end, 2.0f), r[i].begin) << "prim " << prim;
    }
  }

  std::vector<TestMesh> meshes;
  std::unique_ptr<Structure> structure;
  Keeper keeper;
};

TEST_F(NodeVisitorTest, boxes_contain_their_triangles_at_every_time) {
  build({sphere(12, 9), soup(300, 5, 7), sphere(6, 1)});
  check_boxes(0, {});
}

TEST_F(NodeVisitorTest, boxes_of_indexed_leaves_and_of_meshes_that_are_there_for_a_part) {
  build({timed(soup(400, 9, 3), {0.25f, 0.75f}), sphere(8, 17)}, 0.0f);
  check_boxes(0, {});
  check_coverage(0);
  check_coverage(1);
}

TEST_F(NodeVisitorTest, time_ranges_of_children_cover_the_parents) {
  build({soup(500, 17, 11)});
  check_coverage(0);
  std::size_t own = 0;
  for (const KeptNode& kept : keeper.nodes) {
    std::vector<TimeRange> ranges;
    for (std::size_t child : kept.children) {
      const TreeNode& node = keeper.nodes[child].node;
      EXPECT_GE(node.time_range.begin, kept.node.time_range.begin);
      EXPECT_LE(node.time_range.end, kept.node.time_range.end);
      const bool differs = node.time_range.begin != kept.node.time_range.begin ||
                           node.time_range.end != kept.node.time_range.end;
      EXPECT_EQ(node.has_own_range, differs);
      own += differs ? 1 : 0;
      ranges.push_back(node.time_range);
    }
    if (ranges.empty()) continue;
    std::sort(ranges.begin(), ranges.end(), [](TimeRange a, TimeRange b) { return a.begin < b.begin; });
    EXPECT_EQ(ranges.front().begin, kept.node.time_range.begin);
    float covered = ranges.front().end;
    for (TimeRange r : ranges) {
      EXPECT_LE(r.begin, std::nextafter(covered, 2.0f)) << "a gap between the children's ranges";
      covered = std::max(covered, r.end);
    }
    EXPECT_EQ(covered, kept.node.time_range.end);
  }
  EXPECT_GT(structure->statistics().temporal_splits, 0u);
  EXPECT_GT(own, 0u);
}

TEST_F(NodeVisitorTest, counts_agree_with_the_statistics) {
  for (float share : {1.0f, 0.3f, 0.0f}) {
    keeper = Keeper();
    build({sphere(12, 9), soup(300, 9, 5)}, share);
    const BuildStatistics& s = structure->statistics();
    std::map<NodeKind, std::size_t> counts;
    std::size_t deepest = 0, triangles = 0;
    for (const KeptNode& kept : keeper.nodes) {
      ++counts[kept.node.kind];
      triangles += kept.prims.size();
      if (is_leaf(kept.node.kind)) deepest = std::max(deepest, kept.node.level);
    }
    EXPECT_EQ(counts[NodeKind::kStatic], s.nodes[0]);
    EXPECT_EQ(counts[NodeKind::kLinear], s.nodes[1]);
    EXPECT_EQ(counts[NodeKind::kSpatialTemporal], s.nodes[2]);
    EXPECT_EQ(counts[NodeKind::kInlineLeaf], s.inline_leaves);
    EXPECT_EQ(counts[NodeKind::kIndexedLeaf], s.indexed_leaves);
    EXPECT_EQ(triangles, s.leaf_triangles);
    EXPECT_EQ(deepest, s.depth);
  }
}

TEST_F(NodeVisitorTest, does_not_go_below_what_is_not_entered) {
  build({sphere(12, 9)});
  const std::size_t second_level = keeper.nodes.front().children.size();
  Keeper shallow(2);
  structure->visit_nodes(shallow);
  EXPECT_EQ(shallow.nodes.size(), 1 + second_level);
  EXPECT_LT(shallow.nodes.size(), keeper.nodes.size());
}

TEST_F(NodeVisitorTest, an_empty_structure_and_a_single_leaf) {
  build({});
  EXPECT_TRUE(keeper.nodes.empty());
  keeper = Keeper();
  build({soup(1, 3, 2)});
  ASSERT_EQ(keeper.nodes.size(), 1u);
  EXPECT_TRUE(is_leaf(keeper.nodes[0].node.kind));
  check_boxes(0, {});
}

}  // namespace
}  // namespace stbvh::test
