/// The tree finds, bit for bit, what the triangle test accepts without a tree: in scenes and for rays chosen
/// to hurt, with and without flush-to-zero, on every instruction set, in inline and indexed leaves.
#include <gtest/gtest.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "flush_to_zero.h"
#include "hard_meshes.h"
#include "limited.h"
#include "stbvh/structure.h"
#include "test_meshes.h"
#include "unculled.h"

namespace stbvh {
namespace {

using test::flat;
using test::FlushToZero;
using test::needles;
using test::ordinary;
using test::Random;
using test::TestMesh;

constexpr float kInf = std::numeric_limits<float>::infinity();

std::vector<MeshView> views(std::vector<TestMesh>& meshes) {
  std::vector<MeshView> v;
  for (TestMesh& mesh : meshes) v.push_back(mesh.view());
  return v;
}

// Meshes ----------------------------------------------------------------------------------------------------

struct Scene {
  std::string name;
  float scale;  ///< about the extent of what is in it
  std::vector<TestMesh> meshes;
};

std::vector<TestMesh> mixed_grids(bool ranges_touch) {
  constexpr std::size_t kSteps[] = {2, 3, 5, 7, 13, 16};
  std::vector<TestMesh> meshes;
  for (const std::size_t steps : kSteps) {
    const auto i = static_cast<std::uint32_t>(meshes.size());
    meshes.push_back(ordinary(12, steps, 30 + i));
    if (ranges_touch) {
      meshes.back().time_range = {static_cast<float>(i) / 6.0f, static_cast<float>(i + 1) / 6.0f};
    }
  }
  return meshes;
}

/// One step at 0, the others in the last hundredth.
std::vector<float> long_and_short(std::size_t steps) {
  std::vector<float> times = test::uneven_times(steps - 1, 5, 0.99f, 1.0f);
  times.insert(times.begin(), 0.0f);
  return times;
}

std::vector<Scene> all_scenes() {
  constexpr TimeRange kInner{0.1f, 0.9f};
  std::vector<Scene> scenes;
  const auto add = [&](const char* name, float scale, std::vector<TestMesh> meshes) {
    scenes.push_back({name, scale, std::move(meshes)});
  };
  add("offset_1e3", 1, {placed(ordinary(40, 9, 1), 1, 1e3f), placed(ordinary(20, 1, 2), 1, 1e3f)});
  add("offset_1e6", 1, {placed(ordinary(40, 37, 3), 1, 1e6f), placed(ordinary(20, 1, 4), 1, -1e6f)});
  add("small_at_offset_1e3", 1e-3f, {placed(ordinary(60, 9, 5), 1e-3f, 1e3f)});
  add("scale_1e_minus_15", 1e-15f,
      {placed(ordinary(40, 9, 6), 1e-15f, 0), placed(flat(20, 3, 7, false), 1e-15f, 0)});
  add("scale_1e_minus_3", 1e-3f, {placed(ordinary(60, 9, 8), 1e-3f, 0)});
  add("scale_1e15", 1e15f, {placed(ordinary(60, 9, 9), 1e15f, 0)});
  add("scale_5e17", 5e17f, {placed(ordinary(60, 5, 10), 5e17f, 0)});
  add("steps_129", 1, {timed(ordinary(50, 129, 11), kInner), ordinary(10, 1, 12)});
  add("steps_129_at_offset_1e6", 1, {timed(placed(ordinary(60, 129, 13), 1, 1e6f), kInner)});
  add("mixed_grids", 1, mixed_grids(false));
  add("mixed_grids_one_after_the_other", 1, mixed_grids(true));
  add("fast_motion", 1, {ordinary(50, 7, 14, 5.0f, 1e-3f), ordinary(20, 65, 15, 5.0f, 1e-3f)});
  add("uneven_steps", 1,
      {at_times(ordinary(50, 9, 23), test::uneven_times(9, 1)), ordinary(20, 5, 24), ordinary(10, 1, 25)});
  add("uneven_steps_beyond_the_shutter", 1,
      {at_times(ordinary(40, 17, 26), test::uneven_times(17, 2, -0.5f, 1.5f)),
       at_times(ordinary(20, 33, 27), test::uneven_times(33, 3, 0.25f, 0.75f))});
  add("uneven_steps_1000", 1, {at_times(ordinary(20, 1000, 28), test::uneven_times(1000, 4))});
  add("steps_an_ulp_apart", 1,
      {at_times(ordinary(40, 6, 29),
                {0.0f, std::nextafter(0.5f, 0.0f), 0.5f, std::nextafter(0.5f, 1.0f), 0.75f, 1.0f})});
  add("one_long_step_and_many_short", 1, {at_times(ordinary(40, 34, 30), long_and_short(34))});
  add("needles", 1, {needles(40, 9, 16), needles(20, 1, 17)});
  add("needles_at_offset_1e3", 1, {placed(needles(60, 5, 18), 1, 1e3f)});
  add("flat", 1, {flat(50, 5, 19, false), flat(20, 1, 20, false)});
  add("in_one_plane", 1, {flat(50, 5, 21, true), flat(20, 1, 22, true)});
  return scenes;
}

// Rays ------------------------------------------------------------------------------------------------------

/// A point of a triangle (inside, on an edge or a corner) at `time`, rounded once.
Vec3f point_on(const TestMesh& mesh, std::size_t triangle, float time, Random& random) {
  const std::size_t segments = mesh.positions.size() - 1;
  std::size_t k = 0;
  while (k + 1 < segments && mesh.time_of_step(k + 1) <= time) ++k;
  double f = 0.0;
  if (segments > 0) {
    const double begin = mesh.time_of_step(k), end = mesh.time_of_step(k + 1);
    f = std::clamp((time - begin) / (end - begin), 0.0, 1.0);
  }
  double weight[3] = {random.unit(), random.unit(), random.unit()};
  const std::uint32_t kind = random.bits() % 4;
  if (kind < 2) weight[random.bits() % 3] = 0.0;  // an edge, or, with the next line, perhaps a corner
  if (kind < 1) weight[random.bits() % 3] = 0.0;
  const double sum = weight[0] + weight[1] + weight[2];
  double p[3] = {0, 0, 0};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t vertex = mesh.indices[3 * triangle + corner];
    const Vec3f& a = mesh.positions[k][vertex];
    const Vec3f& b = mesh.positions[segments > 0 ? k + 1 : 0][vertex];
    const double w = weight[corner] / sum;
    p[0] += w * ((1 - f) * a.x + f * b.x);
    p[1] += w * ((1 - f) * a.y + f * b.y);
    p[2] += w * ((1 - f) * a.z + f * b.z);
  }
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

/// Somewhere, or at the boundary of two steps of `mesh` or one float beside it, or at an end of all time.
float random_time(const TestMesh& mesh, Random& random) {
  const TimeRange range = mesh.time_range;
  float time = random.between(range.begin, range.end);
  const std::uint32_t kind = random.bits() % 8;
  if (kind < 5 && mesh.positions.size() > 1) {
    time = mesh.time_of_step(random.bits() % static_cast<std::uint32_t>(mesh.positions.size()));
    if (kind == 3) time = std::nextafter(time, 2.0f);
    if (kind == 4) time = std::nextafter(time, -1.0f);
  }
  if (kind == 7) time = static_cast<float>(random.bits() % 2);
  return std::clamp(time, 0.0f, 1.0f);
}

/// Any direction; often with components that are zero of either sign, or next to nothing.
Vec3f random_direction(Random& random) {
  constexpr float kSmall[] = {0.0f, -0.0f, 0.0f, -0.0f, 1e-20f, -1e-7f, 1e-42f};
  const Vec3f d = random.point(1.0f);
  float components[3] = {d.x, d.y, d.z};
  const std::uint32_t kind = random.bits() % 4;
  for (std::uint32_t i = 0; i < kind && i < 2; ++i) {
    components[random.bits() % 3] = kSmall[random.bits() % std::size(kSmall)];
  }
  return {components[0], components[1], components[2]};
}

Ray random_ray(const Scene& scene, Random& random) {
  constexpr float kDistances[] = {0.5f, 3.0f, 3.0f, 1e4f};
  constexpr float kLengths[] = {1.0f, 1.0f, 0x1p-60f, 0x1p30f};
  const TestMesh& mesh = scene.meshes[random.bits() % scene.meshes.size()];
  const TestMesh& clock = scene.meshes[random.bits() % scene.meshes.size()];
  const float time = random_time(random.bits() % 2 == 0 ? mesh : clock, random);
  const Vec3f target = point_on(mesh, random.bits() % (mesh.indices.size() / 3), time, random);
  const Vec3f d = random_direction(random);
  const float distance = kDistances[random.bits() % std::size(kDistances)] * scene.scale;
  const float length = kLengths[random.bits() % std::size(kLengths)];
  Ray ray{};
  ray.origin = {target.x - distance * d.x, target.y - distance * d.y, target.z - distance * d.z};
  ray.direction = {length * d.x, length * d.y, length * d.z};
  ray.tfar = kInf;
  ray.time = time;
  ray.mask = 0xFFFFFFFFu;
  return ray;
}

// The comparison --------------------------------------------------------------------------------------------

struct Tally {
  int rays = 0, hits = 0, wrong = 0;
  double off_plane = 0;  ///< of the hit that lies farthest off
};

std::string describe(const Ray& ray) {
  char text[256];
  std::snprintf(text, sizeof text, "origin (%a, %a, %a) direction (%a, %a, %a) time %a", ray.origin.x,
                ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z, ray.time);
  return text;
}

/// Whether any hit and closest hit agree where the range ends at a hit at `t`, on either side of it.
bool agree_around(const Structure& structure, Isa isa, Ray ray, float t) {
  const float before = std::nextafter(t, -kInf);
  const float ranges[][2] = {{t, ray.tfar}, {before, ray.tfar}, {ray.tnear, before}, {ray.tnear, t}};
  Hit hit;
  for (const auto& [tnear, tfar] : ranges) {
    ray.tnear = tnear;
    ray.tfar = tfar;
    if (structure.intersect_on(isa, ray, hit) != structure.occluded_on(isa, ray)) return false;
  }
  return true;
}

/// Whether the tree answers `ray` as `expected`; where two triangles are hit at the same t, either will do.
bool agrees(const Structure& structure, const std::optional<Hit>& expected, Isa isa, Ray ray) {
  Hit hit{};
  if (structure.intersect_on(isa, ray, hit) != expected.has_value()) return false;
  if (structure.occluded_on(isa, ray) != expected.has_value()) return false;
  if (!expected) return true;
  const auto same = [&] {
    if (hit.t != expected->t) return false;
    if (hit.prim_id != expected->prim_id || hit.geom_id != expected->geom_id) return true;
    return hit.u == expected->u && hit.v == expected->v && hit.normal.x == expected->normal.x &&
           hit.normal.y == expected->normal.y && hit.normal.z == expected->normal.z;
  };
  if (!same() || !agree_around(structure, isa, ray, expected->t)) return false;
  // Nothing but the hit is left of the ray: boxes may not be cut any closer.
  ray.tfar = expected->t;
  ray.tnear = std::nextafter(expected->t, -kInf);
  return structure.occluded_on(isa, ray) && structure.intersect_on(isa, ray, hit) && same();
}

/// Compares on every instruction set, traced with and without flush-to-zero.
template <typename MakeRay>
Tally compare(std::span<const MeshView> meshes, const BuildSettings& settings, bool flush_build, int rays,
              const MakeRay& make_ray) {
  std::unique_ptr<Structure> structure;
  std::unique_ptr<test::Unculled> unculled;
  {
    const FlushToZero guard(flush_build);
    structure = Structure::build(meshes, settings);
    unculled = std::make_unique<test::Unculled>(meshes);
  }
  Tally tally;
  for (int i = 0; i < test::count(rays); ++i) {
    const Ray ray = make_ray();
    for (const bool flush_trace : {false, true}) {
      const FlushToZero guard(flush_trace);
      for (const Isa isa : available_isas()) {
        const std::optional<Hit> expected = unculled->intersect(isa, ray, &tally.off_plane);
        ++tally.rays;
        tally.hits += expected.has_value();
        if (agrees(*structure, expected, isa, ray)) continue;
        if (tally.wrong++ == 0) {
          ADD_FAILURE() << isa_name(isa) << (flush_trace ? ", traced flushing, " : ", ") << describe(ray);
        }
      }
    }
  }
  return tally;
}

/// Of the memory beyond that of the smallest structure.
constexpr float kShares[] = {1.0f, 0.0f};

class RobustnessOf : public testing::TestWithParam<Scene> {};

INSTANTIATE_TEST_SUITE_P(Scenes, RobustnessOf, testing::ValuesIn(all_scenes()),
                         [](const auto& param_info) { return param_info.param.name; });

TEST_P(RobustnessOf, TreeFindsWhatTheTriangleTestAccepts) {
  Scene scene = GetParam();
  for (std::uint32_t i = 0; i < scene.meshes.size(); ++i) scene.meshes[i].geom_id = i;
  const std::vector<MeshView> meshes = views(scene.meshes);
  Random random(99);
  for (const float share : kShares) {
    for (const bool flush_build : {false, true}) {
      SCOPED_TRACE((share > 0 ? "inline" : "indexed") + std::string(flush_build ? ", built flushing" : ""));
      const BuildSettings settings = test::limited(meshes, share);
      const Tally tally =
          compare(meshes, settings, flush_build, 2000, [&] { return random_ray(scene, random); });
      EXPECT_EQ(tally.wrong, 0) << "of " << tally.rays;
      EXPECT_LE(tally.off_plane, 1);
      EXPECT_GT(tally.hits, tally.rays / 20);
    }
  }
}

/// Coordinates, directions and distances are a few units of the least denormal number: nothing is lost, and
/// nothing is found that is not there. Most rays miss, as points of triangles are rounded away from them.
TEST(Robustness, ScenesOfDenormalSize) {
  for (const float size : {3e-39f, 1e-41f, 3e-44f}) {
    const std::vector<TestMesh> meshes{placed(ordinary(30, 5, 47), size, 0),
                                       placed(ordinary(30, 1, 48), size, 0)};
    Scene scene{"", size, meshes};
    scene.meshes[1].geom_id = 1;
    Random random(49);
    const Tally tally = compare(views(scene.meshes), {}, false, 1000, [&] {
      Ray ray = random_ray(scene, random);
      if (random.bits() % 2 == 0) {
        const Vec3f d = random_direction(random);
        ray.direction = {size * d.x, size * d.y, size * d.z};
      }
      return ray;
    });
    EXPECT_EQ(tally.wrong, 0) << size << ", of " << tally.rays;
    EXPECT_GT(tally.hits, 0) << size;
  }
}

// Time ranges -----------------------------------------------------------------------------------------------

/// Lengths that are denormal, so that denormals-are-zero takes them for nothing: refused, or answered right.
TEST(Robustness, TimeRangesOfDenormalLength) {
  constexpr TimeRange kRanges[] = {{0.0f, 1e-40f}, {0.0f, 1e-45f}, {-1e-40f, 1e-40f}, {1.2e-38f, 1.21e-38f}};
  for (const TimeRange range : kRanges) {
    for (const std::size_t steps : {2u, 5u, 129u}) {
      std::vector<TestMesh> meshes{timed(ordinary(30, steps, 41), range)};
      const Scene scene{"", 1, meshes};
      const std::vector<MeshView> mesh_views = views(meshes);
      for (const float share : kShares) {
        for (const bool flush_build : {false, true}) {
          Random random(42);
          try {
            const BuildSettings settings = test::limited(mesh_views, share);
            const Tally tally =
                compare(mesh_views, settings, flush_build, 100, [&] { return random_ray(scene, random); });
            EXPECT_EQ(tally.wrong, 0) << range.begin << " to " << range.end << ", " << steps << " steps";
          } catch (const InvalidMesh& refused) {
            EXPECT_NE(std::string(refused.what()), "");
          }
        }
      }
    }
  }
}

/// Threads of a build need not have the flush-to-zero mode of the caller: what is alive must not depend on
/// it.
TEST(Robustness, DenormalTimesCountAsZero) {
  const float denormal = std::numeric_limits<float>::denorm_min();
  const float least = std::numeric_limits<float>::min();
  for (const bool flush : {false, true}) {
    const FlushToZero guard(flush);
    for (const float end : {0.0f, -0.0f, -denormal, denormal}) {
      std::vector<TestMesh> meshes{timed(ordinary(100, 3, 45), {-1.0f, end})};
      const auto structure = Structure::build(views(meshes));
      EXPECT_EQ(structure->statistics().triangles, views(meshes)[0].triangle_count) << flush << " " << end;
    }
    std::vector<TestMesh> meshes{timed(ordinary(100, 3, 45), {-denormal, 0.9f * least})};
    EXPECT_THROW(Structure::build(views(meshes)), InvalidMesh) << flush;
  }
}

TEST(Robustness, TimeRangesFarBeyondTheShutter) {
  for (const TimeRange range :
       {TimeRange{-1000.0f, 1000.0001f}, TimeRange{-1e6f, 1.0f}, TimeRange{0.0f, 3e30f}}) {
    for (const std::size_t steps : {2u, 9u, 129u}) {
      std::vector<TestMesh> meshes{timed(ordinary(1000, steps, 43), range)};
      const Scene scene{"", 1, meshes};
      Random random(44);
      const Tally tally = compare(views(meshes), {}, false, 50, [&] { return random_ray(scene, random); });
      EXPECT_EQ(tally.wrong, 0) << range.begin << " to " << range.end << ", " << steps << " steps";
      EXPECT_GT(tally.hits, 0);
    }
  }
}

TEST(Robustness, MeshesNeverAliveAreNotInvalid) {
  std::vector<TestMesh> meshes{ordinary(50, 5, 45), timed(ordinary(70, 5, 46), {2.0f, 3.0f}),
                               timed(ordinary(30, 2, 47), {-3.0f, -1.0f})};
  EXPECT_EQ(Structure::build(views(meshes))->statistics().invalid_triangles, 0u);
  meshes[0].indices[4] = 0xFFFFFFFFu;
  EXPECT_EQ(Structure::build(views(meshes))->statistics().invalid_triangles, 1u);
  meshes.erase(meshes.begin());
  EXPECT_EQ(Structure::build(views(meshes))->statistics().invalid_triangles, 0u);
}

// Cancelled task groups -------------------------------------------------------------------------------------

/// Builds in a task of a group that is cancelled at once or at a tenth of the way; the tree must be whole if
/// there is one.
TEST(Robustness, BuildInACancelledTaskGroupIsWholeOrThrows) {
  std::vector<TestMesh> meshes{test::sphere(30, 9), test::soup(9000, 3, 48, 0.05f)};
  const std::vector<MeshView> mesh_views = views(meshes);
  const std::uint64_t expected = Structure::build(mesh_views)->tree_hash();
  for (const int tenth : {-1, 0, 2, 5, 8}) {
    tbb::task_group group;
    group.run([&] {
      BuildCallbacks callbacks;
      callbacks.progress = [&](double fraction) {
        if (fraction >= tenth / 10.0) group.cancel();
        return true;
      };
      if (tenth < 0) group.cancel();
      try {
        EXPECT_EQ(Structure::build(mesh_views, {}, callbacks)->tree_hash(), expected) << tenth;
      } catch (const BuildCancelled&) {
        SUCCEED();
      }
    });
    group.wait();
  }
}

}  // namespace
}  // namespace stbvh
