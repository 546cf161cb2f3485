// stbvhIntersect1 and stbvhOccluded1: what rtcIntersect1 and rtcOccluded1 give of a scene with the geometry
// alone.
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <thread>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

/// A ray with something of the application's behind it.
struct SpacedRay {
  RTCRayHit rayhit;
  unsigned beside[4];
};

std::vector<SpacedRay> random_rays(std::uint32_t seed, unsigned count) {
  const unsigned masks[] = {0u, 1u, 2u, 6u, 0xFFFFFFFFu, 0xFFFFFFFFu};
  Random random(seed);
  std::vector<SpacedRay> rays(count);
  for (unsigned i = 0; i < count; ++i) {
    rays[i] = {random_ray(random), {i, i, i, i}};
    rays[i].rayhit.ray.mask = masks[random.below(6)];
  }
  return rays;
}

/// Rays of some masks through both, one by one and many in a call; there must be hits and misses enough.
void expect_same_bits(const ScenePair& pair, std::uint32_t seed, unsigned count = 3000) {
  const std::vector<SpacedRay> rays = random_rays(seed, count);
  std::vector<SpacedRay> closest = rays, any = rays;
  intersect_many(pair.geometry.get(), &closest[0].rayhit, count, sizeof(SpacedRay));
  occluded_many(pair.geometry.get(), &any[0].rayhit.ray, count, sizeof(SpacedRay));
  unsigned hits = 0;
  for (unsigned i = 0; i < count; ++i) {
    const RTCRayHit& ray = rays[i].rayhit;
    const RTCRayHit expected = intersect(pair.own.get(), ray);
    ASSERT_TRUE(same_bits(intersect_directly(pair.geometry.get(), ray), expected)) << i;
    ASSERT_TRUE(same_bits(closest[i].rayhit, expected)) << i;
    const bool hit = expected.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    ASSERT_EQ(is_occluded_directly(pair.geometry.get(), ray), hit) << i;
    ASSERT_EQ(any[i].rayhit.ray.tfar, hit ? -std::numeric_limits<float>::infinity() : ray.ray.tfar) << i;
    any[i].rayhit.ray.tfar = ray.ray.tfar;
    ASSERT_EQ(std::memcmp(&any[i], &rays[i], sizeof(SpacedRay)), 0) << i;
    ASSERT_EQ(std::memcmp(closest[i].beside, rays[i].beside, sizeof closest[i].beside), 0) << i;
    hits += hit;
  }
  EXPECT_GT(hits, count / 10);
  EXPECT_LT(hits, count);
}

std::vector<TestMesh> mixed_meshes() {
  std::vector<TestMesh> meshes{triangle_soup(1, 100, 1), triangle_soup(2, 100, 5), triangle_soup(3, 100, 9)};
  meshes[0].mask = 3;
  meshes[1].start_time = .2f, meshes[1].end_time = .7f;
  meshes[2].mask = 4;
  return meshes;
}

TEST(PluginDirectQueries, GiveTheBitsOfEmbreesQueries) {
  const Device device = new_device();
  expect_same_bits(scene_pair(device, mixed_meshes()), 1);
  expect_same_bits(scene_pair(device, {triangle_soup(4, 300, 1)}), 2);
  expect_same_bits(scene_pair(device, {triangle_soup(5, 300, 17)}), 3);
}

TEST(PluginDirectQueries, InFlight) {
  const Device device = new_device();
  std::vector<TestMesh> meshes = mixed_meshes();
  meshes.push_back(large_mesh_far_away());
  const ScenePair pair = scene_pair(device, meshes);
  StbvhStatistics statistics;
  stbvhInitStatistics(&statistics);
  ASSERT_EQ(stbvhGetStatistics(pair.geometry.get(), &statistics), RTC_ERROR_NONE);
  EXPECT_GT(statistics.structureBytes, 3u << 20);
  expect_same_bits(pair, 12);
}

TEST(PluginDirectQueries, OfAnyPrecisionAndLimit) {
  const Device device = new_device();
  ScenePair pair = scene_pair(device, mixed_meshes());
  const StbvhGeometry g = pair.geometry.get();
  ASSERT_EQ(stbvhSetGeometryPrecision(g, STBVH_PRECISION_FAST), RTC_ERROR_NONE);
  StbvhStatistics all;
  stbvhInitStatistics(&all);
  ASSERT_EQ(stbvhGetStatistics(g, &all), RTC_ERROR_NONE);
  for (const std::size_t percent : {100u, 80u, 50u}) {
    ASSERT_EQ(stbvhSetGeometryMaxBytes(g, all.structureBytes * percent / 100, STBVH_NO_LIMIT),
              RTC_ERROR_NONE);
    ASSERT_EQ(stbvhCommitGeometry(g), RTC_ERROR_NONE);
    rtcCommitScene(pair.own.get());
    expect_same_bits(pair, 4);
  }
}

TEST(PluginDirectQueries, TakeTheInstanceFromTheContextAsEmbreeDoes) {
  const Device device = new_device();
  const ScenePair pair = scene_pair(device, {flat_triangle(0, 3)});
  const RTCRayHit ray = ray_down(.1f, .1f, .5f);
  const RTCRayHit hit = intersect_directly(pair.geometry.get(), ray);
  EXPECT_EQ(hit.hit.geomID, 0u);
  EXPECT_EQ(hit.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
  QueryContext context = new_context();
  EXPECT_TRUE(same_bits(intersect_directly(pair.geometry.get(), ray, {.context = &context}), hit));
  context.instID[0] = 5;
  EXPECT_EQ(intersect_directly(pair.geometry.get(), ray, {.context = &context}).hit.instID[0], 5u);
}

/// Embree's tree leaves out the end of the range that the whole geometry has; the kernels do not.
TEST(PluginDirectQueries, HitAMeshAtTheEndOfItsTimeRange) {
  const Device device = new_device();
  std::vector<TestMesh> meshes{flat_triangle(0, 3)};
  meshes[0].start_time = .25f, meshes[0].end_time = .75f;
  const ScenePair pair = scene_pair(device, meshes);
  const std::pair<float, bool> expected[] = {
      {.2499f, false}, {.25f, true}, {.5f, true}, {.75f, true}, {.7501f, false}};
  for (const auto& [time, hit] : expected) {
    const RTCRayHit ray = ray_down(.1f, .1f, time);
    EXPECT_EQ(intersect_directly(pair.geometry.get(), ray).hit.geomID == 0, hit) << time;
    EXPECT_EQ(is_occluded_directly(pair.geometry.get(), ray), hit) << time;
    EXPECT_EQ(intersect(pair.own.get(), ray).hit.geomID == 0, hit && time != .75f) << time;
  }
}

void keep_even_ones(const RTCFilterFunctionNArguments* args) {
  if (args->context == nullptr || RTCHitN_primID(args->hit, args->N, 0) % 2 != 0) args->valid[0] = 0;
}

/// A context of the application's own, with a filter: filter_test.cpp.
TEST(PluginDirectQueries, WithoutAContextRunTheMeshesFilters) {
  const Device device = new_device();
  std::vector<TestMesh> meshes = mixed_meshes();
  for (TestMesh& mesh : meshes) mesh.intersect_filter = mesh.occluded_filter = keep_even_ones;
  expect_same_bits(scene_pair(device, meshes), 5);
  meshes.push_back(large_mesh_far_away());
  expect_same_bits(scene_pair(device, meshes), 13);
}

TEST(PluginDirectQueries, HitNothingBeforeTheFirstCommitAndAfterOneThatFailed) {
  const Device device = new_device();
  const TestMesh mesh = flat_triangle(0, 3);
  std::vector<const void*> pointers;
  const StbvhMeshArguments arguments = arguments_of(mesh, pointers);
  const OwnGeometry geometry(stbvhNewGeometry(device.get()));
  const RTCRayHit ray = ray_down(.1f, .1f, .5f);
  const auto expect_hit = [&](bool expected) {
    const RTCRayHit found = intersect_directly(geometry.get(), ray);
    EXPECT_EQ(found.hit.geomID == 0, expected);
    EXPECT_EQ(same_bits(found, ray), !expected);
    EXPECT_EQ(is_occluded_directly(geometry.get(), ray), expected);
  };
  expect_hit(false);
  ASSERT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
  expect_hit(false);
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE);
  expect_hit(true);
  ASSERT_EQ(stbvhAddMesh(geometry.get(), &arguments, nullptr), RTC_ERROR_NONE);
  expect_hit(true);  // the last commit answers
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_INVALID_OPERATION);
  expect_hit(false);
}

TEST(PluginDirectQueries, OnManyThreadsAtOnce) {
  const Device device = new_device();
  std::vector<TestMesh> meshes = mixed_meshes();
  meshes[1].intersect_filter = meshes[1].occluded_filter = keep_even_ones;
  const ScenePair pair = scene_pair(device, meshes);
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < 4; ++i) {
    threads.emplace_back([&pair, i] { expect_same_bits(pair, 6 + i, 1000); });
  }
  for (std::thread& thread : threads) thread.join();
}

template <typename Exception>
void throw_one(const RTCFilterFunctionNArguments*) {
  throw Exception("from a filter");
}

struct NoMemory : std::bad_alloc {
  explicit NoMemory(const char*) {}
};

/// As through Embree, whose functions do not let them out either.
TEST(PluginDirectQueries, WhatFiltersThrowBecomesTheDevicesError) {
  const Device device = new_device();
  for (const bool no_memory : {false, true}) {
    std::vector<TestMesh> meshes{flat_triangle(0, 3), large_mesh_far_away()};
    meshes[0].intersect_filter = meshes[0].occluded_filter =
        no_memory ? throw_one<NoMemory> : throw_one<std::runtime_error>;
    const OwnGeometry geometry = own_geometry(device, meshes);
    const RTCError expected = no_memory ? RTC_ERROR_OUT_OF_MEMORY : RTC_ERROR_UNKNOWN;
    RTCRayHit ray = ray_down(.1f, .1f, .5f);
    intersect_one(geometry.get(), ray);
    EXPECT_EQ(rtcGetDeviceError(device.get()), expected);
    ray = ray_down(.1f, .1f, .5f);
    occluded_one(geometry.get(), ray.ray);
    EXPECT_EQ(rtcGetDeviceError(device.get()), expected);
    std::vector<RTCRayHit> rays;
    for (int i = 0; i < 20; ++i) rays.push_back(ray_down(.01f * static_cast<float>(i), .1f, .5f));
    intersect_many(geometry.get(), rays.data(), rays.size(), sizeof(RTCRayHit));
    EXPECT_EQ(rtcGetDeviceError(device.get()), expected);
  }
}

TEST(PluginDirectQueries, RefuseRaysThatCannotBe) {
  const Device device = new_device();
  std::vector<TestMesh> meshes{flat_triangle(0, 3)};
  const OwnGeometry geometry = own_geometry(device, meshes);
  const std::vector<RTCRayHit> before(4, ray_down(.1f, .1f, .5f));
  std::vector<RTCRayHit> rays = before;
  const auto expect = [&](RTCRayHit* first, std::size_t count, std::size_t stride, RTCError error) {
    intersect_many(geometry.get(), first, count, stride);
    EXPECT_EQ(rtcGetDeviceError(device.get()), error) << count << " rays, stride " << stride;
    EXPECT_EQ(std::memcmp(rays.data(), before.data(), rays.size() * sizeof(RTCRayHit)), 0);
    occluded_many(geometry.get(), first == nullptr ? nullptr : &first->ray, count,
                  stride == sizeof(RTCRayHit) - 4 ? sizeof(RTCRay) - 4 : stride);
    EXPECT_EQ(rtcGetDeviceError(device.get()), error) << count << " rays, stride " << stride;
    EXPECT_EQ(std::memcmp(rays.data(), before.data(), rays.size() * sizeof(RTCRayHit)), 0);
  };
  expect(nullptr, 1, sizeof(RTCRayHit), RTC_ERROR_INVALID_ARGUMENT);
  expect(rays.data(), 2, 0, RTC_ERROR_INVALID_ARGUMENT);
  expect(rays.data(), 2, sizeof(RTCRayHit) - 4, RTC_ERROR_INVALID_ARGUMENT);
  expect(rays.data(), 2, sizeof(RTCRayHit) + 2, RTC_ERROR_INVALID_ARGUMENT);
  const std::size_t most = std::numeric_limits<std::size_t>::max();
  for (const std::size_t count : {std::size_t{2}, std::size_t{3}, std::size_t{5}, most / 2, most}) {
    for (const std::size_t stride : {most - 95, most - 3, most / 2 + 1}) {
      expect(rays.data(), count, stride, RTC_ERROR_INVALID_ARGUMENT);
    }
  }
  expect(rays.data(), 3, most / 4 + 1, RTC_ERROR_INVALID_ARGUMENT);
  expect(rays.data(), most, sizeof(RTCRayHit), RTC_ERROR_INVALID_ARGUMENT);
  expect(nullptr, 0, 0, RTC_ERROR_NONE);
  expect(rays.data(), 0, 0, RTC_ERROR_NONE);
  intersect_many(StbvhGeometry{}, rays.data(), 1, sizeof(RTCRayHit));
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  intersect_many(geometry.get(), rays.data(), 1, 0);  // of one ray there is none
  EXPECT_EQ(rays[0].hit.geomID, 0u);
}

}  // namespace
}  // namespace stbvh::test
