/// box-sequence, box-sequence-tsah and msbvh.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "harness/oracle/judge.h"
#include "harness/rays/ray_generator.h"
#include "harness/structures/gallery/box_sequence.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/right_answers.h"
#include "tests/harness/test_scenes.h"
#include "tests/harness/trace_all.h"

namespace stbvh::harness {
namespace {

/// Long triangles in all directions, whose boxes overlap: meshes of `steps`, each step a jump by up to
/// `jump`.
Scene stick_scene(std::initializer_list<std::size_t> steps, double jump, double scale = 1.0,
                  double shift = 0.0) {
  Scene scene;
  const Vec3 shifts{shift, shift, shift};
  scene.camera.position = to_float(Vec3{5, 5, 30} * scale + shifts);
  scene.camera.target = to_float(Vec3{5, 5, 5} * scale + shifts);
  Pcg32 random(9);
  const auto vector = [&](double size) {
    const double x = random.uniform(-size, size);
    const double y = random.uniform(-size, size);
    return Vec3{x, y, random.uniform(-size, size)};
  };
  for (const std::size_t count : steps) {
    Mesh& mesh = scene.meshes.emplace_back();
    for (std::size_t k = 0; k < count; ++k) mesh.steps.emplace_back(3 * 200);
    for (std::uint32_t i = 0; i < 3 * 200; i += 3) {
      const Vec3 centre = Vec3{5, 5, 5} + vector(4), half = vector(3), width = vector(0.3);
      for (VertexBuffer& step : mesh.steps) {
        const Vec3 moved = centre + vector(jump);
        std::size_t corner = i;
        for (const Vec3& p : {moved - half, moved + half, moved + half + width})
          step[corner++] = to_float(p * scale + shifts);
      }
      mesh.indices.insert(mesh.indices.end(), {i, i + 1, i + 2});
    }
  }
  return scene;
}

/// Wide floors, of `steps`, which bob and drift, under many small triangles.
Scene floor_scene(std::size_t steps) {
  Scene scene = mixed_step_scene(1);
  Pcg32 random(5);
  scene.meshes = {wandering_triangles(1500, steps, random), Mesh{}};
  for (std::size_t k = 0; k < steps; ++k) {
    VertexBuffer& step = scene.meshes[1].steps.emplace_back(12);
    const auto drift = static_cast<float>(k) * 0.2f;
    for (std::uint32_t i = 0; i < 12; ++i) {
      const auto height = static_cast<float>(i / 4) * 3.0f + (k % 2 == 0 ? 1.0f : 1.5f);
      step[i] = {i % 2 == 0 ? drift : 10.0f + drift, height, i % 4 < 2 ? 0.0f : 10.0f};
    }
  }
  for (std::uint32_t i = 0; i < 12; i += 4) {
    scene.meshes[1].indices.insert(scene.meshes[1].indices.end(), {i, i + 1, i + 2});
    scene.meshes[1].indices.insert(scene.meshes[1].indices.end(), {i + 1, i + 2, i + 3});
  }
  return scene;
}

class EachSequence : public ::testing::TestWithParam<std::string_view> {};

void expect_right_answers(std::string_view name, const Scene& scene) {
  expect_right_answers(*build_structure(name, scene, 2), scene, 2500, 100);
}

/// The triangle test is the same, so the distances are the same bits.
void expect_same_hits(std::string_view name, const Scene& scene, std::span<const Ray> rays) {
  const auto structure = build_structure(name, scene, 2);
  const auto reference = build_structure("stbvh-direct", scene, 2);
  std::size_t hits = 0;
  for (const Ray& ray : rays) {
    Hit hit, expected;
    const bool is_hit = reference->intersect_one(ray, expected);
    ASSERT_EQ(structure->intersect_one(ray, hit), is_hit) << "time " << ray.time;
    ASSERT_EQ(structure->occluded_one(ray), is_hit);
    if (!is_hit) continue;
    ASSERT_EQ(hit.t, expected.t);
    ++hits;
  }
  EXPECT_GT(hits, rays.size() / 10);
}

TEST_P(EachSequence, AgreesWithTheOracleOnUnlikeSteps) {
  expect_right_answers(GetParam(), mixed_step_scene());
}

TEST_P(EachSequence, AgreesWithTheOracleOnUnevenSteps) {
  expect_right_answers(GetParam(), uneven_step_scene());
}

TEST_P(EachSequence, AgreesWithTheOracleOnNestedSteps) {
  expect_right_answers(GetParam(), stick_scene({3, 5, 9, 1}, 1.0));
}

TEST_P(EachSequence, AgreesWithTheOracleOnMultiplesThatAreTooFine) {
  expect_right_answers(GetParam(), stick_scene({14, 12, 2}, 0.5));
}

TEST_P(EachSequence, AgreesWithTheOracleOnFastMotionInManySteps) {
  expect_right_answers(GetParam(), stick_scene({200}, 6.0));
}

TEST_P(EachSequence, AgreesWithTheOracleOnWhatIsSplitInSpace) {
  expect_right_answers(GetParam(), floor_scene(4));
}

TEST_P(EachSequence, FindsEdgesAndCornersOfFastMotion) {
  const Scene scene = stick_scene({129, 65}, 4.0);
  Pcg32 random(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 20000; ++i) {
    const Mesh& mesh = scene.meshes[random.uniform(0, 1) < 0.5 ? 0 : 1];
    const auto time = static_cast<float>(random.uniform(0, 1));
    const double u = time * static_cast<double>(mesh.steps.size() - 1);
    const auto segment = std::min(static_cast<std::size_t>(u), mesh.steps.size() - 2);
    const auto vertex = static_cast<std::size_t>(random.uniform(0, 599.9));
    const Vec3f p = mesh.steps[segment][vertex], q = mesh.steps[segment + 1][vertex];
    const double f = u - static_cast<double>(segment);
    const auto x = static_cast<float>(p.x + f * (q.x - p.x) + random.uniform(-1e-6, 1e-6));
    const auto y = static_cast<float>(p.y + f * (q.y - p.y) + random.uniform(-1e-6, 1e-6));
    Ray ray = ray_along_z(x, y, time);
    ray.origin.z = -20;
    rays.push_back(ray);
  }
  expect_same_hits(GetParam(), scene, rays);
}

TEST_P(EachSequence, HasTheHitsOfOursFromFarAwayAndAtLargeCoordinates) {
  for (const auto& [scale, shift] :
       {std::pair{1.0, 0.0}, {1.0, 3000.0}, {1e6, -1e7}, {1e-12, 0.0}, {1e15, 0.0}}) {
    const Scene scene = stick_scene({5, 3, 1}, 1.0, scale, shift);
    Pcg32 random(4);
    std::vector<Ray> rays;
    for (int i = 0; i < 4000; ++i) {
      const auto at = [&] { return static_cast<float>(random.uniform(1, 9) * scale + shift); };
      Ray ray = ray_along_z(at(), at(), static_cast<float>(random.uniform(0, 1)));
      ray.origin.z = static_cast<float>((i % 2 == 0 ? -30 : -1e5) * scale + shift);
      ray.tfar = std::numeric_limits<float>::infinity();
      rays.push_back(ray);
    }
    SCOPED_TRACE(scale);
    expect_same_hits(GetParam(), scene, rays);
  }
}

TEST_P(EachSequence, HoldsOneTriangleOrNone) {
  Scene scene;
  scene.meshes.push_back(
      one_triangle({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {{{4, 0, 0}, {5, 0, 0}, {4, 1, 0}}}}));
  const auto one = build_structure(GetParam(), scene, 1);
  Hit hit;
  EXPECT_TRUE(one->intersect_one(ray_along_z(2.2f, 0.2f, 0.5f), hit));
  EXPECT_FALSE(one->intersect_one(ray_along_z(0.2f, 0.2f, 0.5f), hit));
  scene.meshes[0].indices.clear();
  EXPECT_FALSE(build_structure(GetParam(), scene, 1)->occluded_one(ray_along_z(2.2f, 0.2f, 0.5f)));
}

TEST_P(EachSequence, OutlinesHoldWhatIsThereAtATime) {
  const Scene scene = stick_scene({5, 3, 1}, 2.0);
  const auto structure = build_structure(GetParam(), scene, 1);
  const float time = 0.3f;
  std::vector<Box4> boxes;
  for (const Outline& corners : structure->outlines_at(time, 3)) {
    Box4& box = boxes.emplace_back(Box4::empty());
    for (const Vec3f& corner : corners) box.extend(F32x4(corner));
  }
  EXPECT_GT(boxes.size(), 20u);
  for (const Mesh& mesh : scene.meshes) {
    const float u = time * static_cast<float>(mesh.steps.size() - 1);
    const auto segment = static_cast<std::size_t>(u);
    const float f = u - static_cast<float>(segment);
    for (std::size_t i = 0; i < mesh.steps[0].size(); ++i) {
      const F32x4 p(mesh.steps[segment][i]);
      const F32x4 q(mesh.steps[std::min(segment + 1, mesh.steps.size() - 1)][i]);
      const F32x4 at = p + F32x4(f) * (q - p);
      const F32x4 slack(1e-5f);
      EXPECT_TRUE(std::ranges::any_of(boxes, [&](const Box4& box) {
        return gallery::inverted_axes({box.lower, at + slack}) == 0 &&
               gallery::inverted_axes({at - slack, box.upper}) == 0;
      }));
    }
  }
}

struct Work {
  std::size_t bytes;
  TraversalCounters counters;
};

Work work_of(std::string_view name, const Scene& scene, unsigned threads) {
  const auto structure = build_structure(name, scene, threads);
  Work work{structure->build_record().structure_bytes, {}};
  for (const Ray& ray : make_rays(RayKind::kUniform, scene, *structure, 2000, 3).rays) {
    Hit hit;
    structure->intersect_one_counted(ray, hit, work.counters);
  }
  return work;
}

TEST_P(EachSequence, IsTheSameHoweverManyThreadsBuildIt) {
  const Scene scene = stick_scene({5, 3, 1, 9, 2, 5, 3, 5}, 0.5);
  const Work one = work_of(GetParam(), scene, 1), two = work_of(GetParam(), scene, 2);
  EXPECT_EQ(one.bytes, two.bytes);
  EXPECT_EQ(one.counters.nodes, two.counters.nodes);
  EXPECT_EQ(one.counters.leaves, two.counters.leaves);
  EXPECT_EQ(one.counters.triangle_tests, two.counters.triangle_tests);
}

TEST_P(EachSequence, FollowsMotion) {
  const Scene scene = stick_scene({33}, 4.0);
  EXPECT_LT(2 * work_of(GetParam(), scene, 2).counters.leaves, work_of("linear", scene, 2).counters.leaves);
}

/// All of the above in a process of its own, on the other instruction set.
TEST(Sequences, HoldsWithoutVectorInstructions) {
  if (std::getenv("STBVH_ISA") != nullptr) GTEST_SKIP() << "is that process";
  std::string path(4096, '\0');
  const ssize_t length = readlink("/proc/self/exe", path.data(), path.size());
  ASSERT_GT(length, 0);
  path.resize(static_cast<std::size_t>(length));
  EXPECT_EQ(
      std::system(
          ("STBVH_ISA=scalar '" + path + "' --gtest_brief=1 --gtest_filter='*/EachSequence.*'").c_str()),
      0);
}

TEST(Sequences, ReferencesAreSplitInSpace) {
  for (const std::size_t steps : {1u, 4u}) {
    const Scene scene = floor_scene(steps);
    const Work whole = work_of("box-sequence-tsah", scene, 2), split = work_of("msbvh", scene, 2);
    EXPECT_GT(split.bytes, whole.bytes);
    EXPECT_LT(split.bytes, 2 * whole.bytes);
    EXPECT_LT(split.counters.nodes, whole.counters.nodes);
  }
}

/// At any time between steps the clipped box holds what is inside the limits.
TEST(Sequences, ClippedBoxesHoldBetweenSteps) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  Pcg32 random(6);
  std::size_t moved = 0;
  for (int round = 0; round < 2000; ++round) {
    std::vector<Box4> whole(1 + static_cast<std::size_t>(random.uniform(0, 6)));
    for (Box4& box : whole) {
      const auto lower = static_cast<float>(random.uniform(-3, 2));
      box = {F32x4(lower, -1, -1), F32x4(lower + static_cast<float>(random.uniform(0, 3)), 1, 1)};
    }
    const bool is_left = round % 2 == 0;
    const Box4 limits =
        is_left ? Box4{F32x4(-inf), F32x4(0, inf, inf)} : Box4{F32x4(0, -inf, -inf), F32x4(inf)};
    std::vector<Box4> clipped = whole;
    gallery::clip(clipped, limits);
    for (std::size_t k = 0; k < whole.size(); ++k) {
      moved += clipped[k].lower[0] != whole[k].lower[0] || clipped[k].upper[0] != whole[k].upper[0];
      const std::size_t next = std::min(k + 1, whole.size() - 1);
      for (double f = 0; f <= 1; f += 0.125) {
        const auto at = [f](float a, float b) { return (1 - f) * a + f * b; };
        const double lower = at(whole[k].lower[0], whole[next].lower[0]);
        const double upper = at(whole[k].upper[0], whole[next].upper[0]);
        const double kept_lower = is_left ? lower : std::max(lower, 0.0);
        const double kept_upper = is_left ? std::min(upper, 0.0) : upper;
        if (kept_lower > kept_upper) continue;
        EXPECT_LE(at(clipped[k].lower[0], clipped[next].lower[0]), kept_lower + 1e-6);
        EXPECT_GE(at(clipped[k].upper[0], clipped[next].upper[0]), kept_upper - 1e-6);
      }
    }
  }
  EXPECT_GT(moved, 500u);
}

INSTANTIATE_TEST_SUITE_P(Sequences, EachSequence,
                         ::testing::Values("box-sequence", "box-sequence-tsah", "msbvh"), [](const auto& p) {
                           std::string name(p.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace stbvh::harness
