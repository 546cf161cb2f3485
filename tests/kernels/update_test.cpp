/// Structure::update: after any edits rays are answered as by a structure built anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "stbvh/structure.h"
#include "test_meshes.h"

namespace stbvh {
namespace {

using test::Random;
using test::TestMesh;

std::vector<MeshView> views(std::vector<TestMesh>& meshes) {
  std::vector<MeshView> v;
  for (TestMesh& mesh : meshes) v.push_back(mesh.view());
  return v;
}

Vec3f point(Random& random, float extent) {
  return {extent * (2 * random.unit() - 1), extent * (2 * random.unit() - 1),
          extent * (2 * random.unit() - 1)};
}

Ray ray_through(Random& random, float extent) {
  const Vec3f from = point(random, 1.5f * extent), to = point(random, 0.8f * extent);
  return {from,
          0.0f,
          {to.x - from.x, to.y - from.y, to.z - from.z},
          random.unit(),
          std::numeric_limits<float>::infinity()};
}

/// The same bits, but for triangles that a ray meets at the same distance.
void expect_as_new(const Structure& updated, std::vector<TestMesh>& meshes, const BuildSettings& settings,
                   std::uint32_t seed, int rays, const std::string& what) {
  const auto fresh = Structure::build(views(meshes), settings);
  EXPECT_EQ(updated.statistics().triangles, fresh->statistics().triangles) << what;
  EXPECT_EQ(updated.statistics().invalid_triangles, fresh->statistics().invalid_triangles) << what;
  EXPECT_EQ(updated.statistics().primitive_segments, fresh->statistics().primitive_segments) << what;
  EXPECT_EQ(updated.statistics().steps_given, fresh->statistics().steps_given) << what;
  EXPECT_EQ(updated.statistics().steps_kept, fresh->statistics().steps_kept) << what;
  Random random(seed);
  for (int i = 0; i < rays; ++i) {
    Ray ray = ray_through(random, 6.0f);
    if (i % 8 == 0) ray.time = static_cast<float>(i / 8 % 9) / 8.0f;  // at steps
    if (i % 5 == 0) ray.mask = 1;
    Hit a, b;
    const bool hit = updated.intersect(ray, a), expected = fresh->intersect(ray, b);
    ASSERT_EQ(hit, expected) << what << ", ray " << i;
    EXPECT_EQ(updated.occluded(ray), expected) << what << ", ray " << i;
    if (!hit) continue;
    ASSERT_EQ(std::bit_cast<std::uint32_t>(a.t), std::bit_cast<std::uint32_t>(b.t)) << what << ", ray " << i;
    // Others may be as far; then either is right.
    if (a.mesh != b.mesh || a.prim_id != b.prim_id) continue;
    EXPECT_EQ(a.geom_id, b.geom_id) << what;
    EXPECT_EQ(a.u, b.u) << what;
    EXPECT_EQ(a.v, b.v) << what;
  }
}

/// A scene that is edited, and its structure.
class EditedScene {
 public:
  EditedScene(std::vector<TestMesh> meshes, const BuildSettings& settings)
      : meshes_(std::move(meshes)), settings_(settings) {
    rebuild();
  }

  std::vector<TestMesh>& meshes() { return meshes_; }
  const BuildSettings& settings() const { return settings_; }
  const Structure& structure() const { return *structure_; }
  std::size_t updates() const { return updates_; }
  const UpdateStatistics& last() const { return last_; }
  /// The first of these is what becomes of the first mesh, and so on.
  std::vector<MeshUpdate>& changes() { return changes_; }

  void add(TestMesh mesh) {
    meshes_.push_back(std::move(mesh));
    changes_.push_back({});
  }
  void remove(std::size_t i) {
    meshes_.erase(meshes_.begin() + static_cast<std::ptrdiff_t>(i));
    changes_.erase(changes_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  void change(std::size_t i, MeshChange change) { changes_[i].change = std::max(changes_[i].change, change); }

  /// True: by an update.
  bool commit() {
    const auto update = structure_->update(views(meshes_), changes_, callbacks_);
    if (update) {
      ++updates_;
      last_ = *update;
    } else {
      rebuild();
    }
    reset_changes();
    return update.has_value();
  }

  BuildCallbacks& callbacks() { return callbacks_; }
  void rebuild() {
    structure_.reset();
    structure_ = Structure::build(views(meshes_), settings_);
    reset_changes();
  }

 private:
  void reset_changes() {
    changes_.clear();
    for (std::size_t i = 0; i < meshes_.size(); ++i) changes_.push_back({i, MeshChange::kNothing});
  }

  std::vector<TestMesh> meshes_;
  BuildSettings settings_;
  BuildCallbacks callbacks_;
  std::vector<MeshUpdate> changes_;
  std::unique_ptr<Structure> structure_;
  std::size_t updates_ = 0;
  UpdateStatistics last_;
};

TestMesh ball(Random& random, std::size_t steps, std::uint32_t rings = 6) {
  return test::sphere(rings, steps, test::tumble, point(random, 4.0f));
}

void translate(TestMesh& mesh, const Vec3f& by) {
  for (auto& step : mesh.positions) {
    for (Vec3f& p : step) p = {p.x + by.x, p.y + by.y, p.z + by.z};
  }
}

std::vector<TestMesh> some_balls(std::uint32_t seed, std::size_t count) {
  Random random(seed);
  constexpr std::array<std::size_t, 4> kSteps{5, 1, 9, 2};
  std::vector<TestMesh> meshes;
  for (std::size_t i = 0; i < count; ++i) {
    meshes.push_back(ball(random, kSteps[i % kSteps.size()]));
    meshes.back().geom_id = static_cast<std::uint32_t>(i);
  }
  return meshes;
}

/// One random edit; returns what it was.
std::string edit(EditedScene& scene, Random& random) {
  const auto up_to = [&](std::size_t n) {
    return std::min(static_cast<std::size_t>(random.unit() * static_cast<float>(n)), n - 1);
  };
  std::vector<TestMesh>& meshes = scene.meshes();
  const std::size_t i = up_to(meshes.size());
  TestMesh& mesh = meshes[i];
  switch (up_to(12)) {
    case 0:
      translate(mesh, point(random, 0.5f));
      scene.change(i, MeshChange::kPositions);
      return "moved a little";
    case 1:
      translate(mesh, point(random, 4.0f));
      scene.change(i, MeshChange::kPositions);
      return "moved far";
    case 2: {  // wobbles, differently at each step
      for (auto& step : mesh.positions) {
        const Vec3f phase = point(random, 3.0f);
        for (Vec3f& p : step) p.z += 0.1f * std::sin(5.0f * p.x + phase.x) * std::cos(4.0f * p.y + phase.y);
      }
      scene.change(i, MeshChange::kPositions);
      return "wobbled";
    }
    case 3:
      for (auto& step : mesh.positions) step = mesh.positions[0];
      scene.change(i, MeshChange::kPositions);
      return "stopped";
    case 4: {  // seams open
      for (auto& step : mesh.positions) {
        for (Vec3f& p : step) p.x += 0.01f * random.unit();
      }
      scene.change(i, MeshChange::kPositions);
      return "scattered";
    }
    case 5:
      mesh.positions[up_to(mesh.positions.size())][up_to(mesh.positions[0].size())].y =
          std::numeric_limits<float>::quiet_NaN();
      scene.change(i, MeshChange::kPositions);
      return "got a vertex that is not finite";
    case 6:
      mesh.mask = random.unit() < 0.5f ? 2u : ~0u;
      return "got another mask";
    case 7: {
      const std::uint32_t id = mesh.geom_id;
      const std::size_t steps = std::array<std::size_t, 4>{1, 2, 5, 9}[up_to(4)];
      mesh = random.unit() < 0.5f ? ball(random, steps, 4)
                                  : test::soup(40, steps, static_cast<std::uint32_t>(i));
      mesh.geom_id = id;
      scene.change(i, MeshChange::kAll);
      return "was replaced";
    }
    case 8: {
      TestMesh added = ball(random, std::array<std::size_t, 3>{1, 3, 9}[up_to(3)], 5);
      if (random.unit() < 0.3f) added = test::timed(added, {0.25f, 0.75f});
      if (random.unit() < 0.3f && added.positions.size() == 9)
        added = test::at_times(added, test::uneven_times(9, 3));
      added.geom_id = static_cast<std::uint32_t>(meshes.size());
      scene.add(std::move(added));
      return "was added";
    }
    case 9:
      if (meshes.size() < 4) return "stayed";
      scene.remove(i);
      return "was removed";
    case 10:
      std::swap(meshes[i], meshes[0]);
      std::swap(scene.changes()[i], scene.changes()[0]);
      return "changed places";
    default: {
      std::vector<std::uint32_t>& indices = mesh.indices;
      if (indices.size() > 12) indices.resize(indices.size() / 6 * 3);
      scene.change(i, MeshChange::kAll);
      return "lost triangles";
    }
  }
}

TEST(Update, RandomEdits) {
  std::size_t updates = 0, commits = 0;
  const char* const asked = std::getenv("STBVH_EDIT_SEQUENCES");  // a long run
  const auto seeds = static_cast<std::uint32_t>(asked != nullptr ? std::atoi(asked) : test::count(60));
  for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
    BuildSettings settings;
    if (seed % 4 == 1) settings.tolerance = kKeepAllSteps;
    EditedScene scene(some_balls(seed, 12), settings);
    Random random(1000 + seed);
    for (int i = 0; i < 10; ++i) {
      std::string what =
          "seed " + std::to_string(seed) + ", edit " + std::to_string(i) + ": a mesh " + edit(scene, random);
      if (i % 3 == 2) what += ", and one " + edit(scene, random);
      updates += scene.commit() ? 1u : 0u;
      ++commits;
      expect_as_new(scene.structure(), scene.meshes(), settings, 77 * seed + static_cast<std::uint32_t>(i),
                    150, what);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  EXPECT_GT(updates, commits / 2);
}

TEST(Update, RefitsWhatMoved) {
  EditedScene scene(some_balls(5, 12), {});
  const std::size_t bytes = scene.structure().statistics().structure_bytes;
  for (auto& step : scene.meshes()[2].positions) {
    for (Vec3f& p : step) p.x += 0.1f;
  }
  scene.change(2, MeshChange::kPositions);
  ASSERT_TRUE(scene.commit());
  EXPECT_EQ(scene.last().meshes_refitted, 1u);
  EXPECT_EQ(scene.last().meshes_built, 0u);
  EXPECT_EQ(scene.last().meshes_removed, 0u);
  EXPECT_GT(scene.last().leaves_refitted, 0u);
  EXPECT_GT(scene.last().expected_cost, 0.9);
  EXPECT_EQ(scene.structure().statistics().structure_bytes, bytes);
  expect_as_new(scene.structure(), scene.meshes(), scene.settings(), 3, 2000, "moved");
}

TEST(Update, BuildsAMeshWhoseVerticesHaveComeApart) {
  // Two triangles whose edge has vertices of its own in each: one vertex of a leaf, as long as they agree.
  std::vector<TestMesh> meshes = some_balls(6, 12);
  TestMesh torn;
  torn.indices = {0, 1, 2, 3, 4, 5};
  for (int step = 0; step < 3; ++step) {
    const float x = static_cast<float>(step * step);
    torn.positions.push_back({{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}});
  }
  meshes.push_back(torn);
  EditedScene scene(std::move(meshes), {});
  for (auto& step : scene.meshes()[12].positions) step[3].z += 0.5f;
  scene.change(12, MeshChange::kPositions);
  ASSERT_TRUE(scene.commit());
  EXPECT_EQ(scene.last().meshes_refitted, 0u);
  EXPECT_EQ(scene.last().meshes_built, 1u);
  expect_as_new(scene.structure(), scene.meshes(), scene.settings(), 4, 2000, "torn");
}

TEST(Update, KeepsToALimit) {
  std::vector<TestMesh> meshes = some_balls(7, 12);
  for (TestMesh& mesh : meshes)
    mesh = test::sphere(14, 9, test::tumble, {static_cast<float>(&mesh - meshes.data()), 0, 0});
  BuildSettings settings;
  settings.tolerance = kKeepAllSteps;
  const std::size_t wanted = Structure::build(views(meshes), settings)->statistics().structure_bytes;
  settings.max_bytes = wanted / 2;
  EditedScene scene(std::move(meshes), settings);
  ASSERT_GT(scene.structure().statistics().indexed_leaves, 0u);
  Random random(8);
  for (int i = 0; i < 12; ++i) {
    if (i % 3 == 2) {
      scene.add(ball(random, 9));
    } else {
      translate(scene.meshes()[static_cast<std::size_t>(i)], {0.1f, 0.1f, 0.0f});
      scene.change(static_cast<std::size_t>(i), MeshChange::kPositions);
    }
    scene.commit();
    EXPECT_LE(scene.structure().statistics().structure_bytes, settings.max_bytes);
    expect_as_new(scene.structure(), scene.meshes(), settings, 9, 500, "edit " + std::to_string(i));
  }
  EXPECT_GT(scene.updates(), 6u);
  settings.max_bytes = kNoLimit;
  settings.max_peak_bytes = 64u << 20;  // which a build keeps to, and an update might not
  EditedScene other(some_balls(7, 12), settings);
  EXPECT_FALSE(other.commit());
}

TEST(Update, GivesUpWhereMostIsNew) {
  EditedScene scene(some_balls(9, 12), {});
  for (std::size_t i = 0; i < 8; ++i) scene.change(i, MeshChange::kAll);
  EXPECT_FALSE(scene.commit());
  while (scene.meshes().size() > 1) scene.remove(0);
  scene.commit();
  expect_as_new(scene.structure(), scene.meshes(), scene.settings(), 5, 500, "one left");
  scene.remove(0);
  EXPECT_FALSE(scene.commit());
  EXPECT_EQ(scene.structure().statistics().triangles, 0u);
}

/// Meshes thrown about until nothing is where the tree was built for: it says so, and is built anew.
TEST(Update, GivesUpWhereRaysWouldBeSlow) {
  EditedScene scene(some_balls(10, 40), {});
  Random random(11);
  std::size_t given_up = 0;
  for (int i = 0; i < 100; ++i) {
    const auto mesh = static_cast<std::size_t>(i * 7 % 40);
    translate(scene.meshes()[mesh], point(random, 6.0f));
    scene.change(mesh, MeshChange::kPositions);
    given_up += scene.commit() ? 0u : 1u;
    if (given_up == 0) {
      EXPECT_LE(scene.last().expected_cost, 1.1);
    }
  }
  EXPECT_GT(given_up, 0u);
  EXPECT_LT(given_up, 90u);
}

TEST(Update, TellsTheBoxesOfWhatChanged) {
  EditedScene scene(some_balls(12, 12), {});
  translate(scene.meshes()[0], {0.01f, 0.02f, 0.03f});
  scene.change(0, MeshChange::kPositions);
  scene.change(5, MeshChange::kAll);
  std::vector<std::size_t> told;
  scene.callbacks().step_bounds = [&](std::size_t mesh, std::vector<Box3f> boxes, std::span<const float>) {
    told.push_back(mesh);
    ASSERT_EQ(boxes.size(), scene.meshes()[mesh].positions.size());
    for (std::size_t step = 0; step < boxes.size(); ++step) {
      Box3f box = Box3f::empty();
      for (const Vec3f& p : scene.meshes()[mesh].positions[step]) box.extend(p);
      EXPECT_EQ(boxes[step].lower.x, box.lower.x);
      EXPECT_EQ(boxes[step].upper.z, box.upper.z);
    }
  };
  ASSERT_TRUE(scene.commit());
  std::ranges::sort(told);
  EXPECT_EQ(told, (std::vector<std::size_t>{0, 5}));
}

TEST(Update, IsCancelled) {
  EditedScene scene(some_balls(13, 12), {});
  std::atomic<int> calls{0};
  scene.callbacks().progress = [&](double) { return ++calls < 2; };
  scene.change(0, MeshChange::kPositions);
  scene.change(5, MeshChange::kAll);
  EXPECT_THROW(scene.commit(), BuildCancelled);
  scene.callbacks().progress = nullptr;
  scene.callbacks().temporary_memory = [](std::ptrdiff_t bytes) { return bytes <= 0; };
  scene.rebuild();
  scene.change(5, MeshChange::kAll);
  EXPECT_THROW(scene.commit(), BuildCancelled);
}

/// Of two, the mesh whose leaves are behind those of the other, or before them: either leaves much room
/// unused.
TEST(Update, GivesUpWhereMemoryWouldLieUnused) {
  for (const std::size_t gone : {0u, 1u}) {
    EditedScene scene({test::sphere(30, 2), test::sphere(28, 2, test::tumble, {100, 0, 0})}, {});
    scene.remove(gone);
    EXPECT_FALSE(scene.commit());
  }
}

TEST(Update, OfMeshesThatComeFromTheSameOrFromNowhere) {
  EditedScene scene(some_balls(14, 12), {});
  scene.meshes()[5] = scene.meshes()[3];
  scene.changes()[5] = {3, MeshChange::kNothing};  // the fourth is it already
  scene.changes()[7].was = 1'000'000;
  ASSERT_TRUE(scene.commit());
  EXPECT_EQ(scene.last().meshes_built, 2u);
  EXPECT_EQ(scene.last().meshes_removed, 2u);
  expect_as_new(scene.structure(), scene.meshes(), scene.settings(), 6, 2000, "odd origins");
  std::vector<MeshUpdate> too_few(3);
  const auto structure = Structure::build(views(scene.meshes()));
  EXPECT_THROW(structure->update(views(scene.meshes()), too_few), std::invalid_argument);
}

}  // namespace
}  // namespace stbvh
