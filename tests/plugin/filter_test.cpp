// Filter functions of meshes and queries, as Embree's own triangles call them.
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

/// The application's own context and ray, larger than Embree's: filters cast to them.
struct Context {
  QueryContext embree = test::new_context();
  unsigned magic = 0xC0FFEE;
  std::set<std::tuple<unsigned, unsigned>> seen;  ///< geomID, primID of each candidate
  unsigned calls = 0;
  unsigned wrong = 0;
};
struct ExtendedRay {
  RTCRayHit embree;
  unsigned magic = 0xBEEF;
};

/// Calls `decide` for each valid lane; false rejects.
template <typename Decide>
void for_each_lane(const RTCFilterFunctionNArguments* args, Decide&& decide) {
  auto& context = *reinterpret_cast<Context*>(args->context);
  ++context.calls;
  if (context.magic != 0xC0FFEE) ++context.wrong;
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const RTCHit hit = rtcGetHitFromHitN(args->hit, args->N, i);
    const RTCRay ray = rtcGetRayFromRayN(args->ray, args->N, i);
    if (!decide(context, ray, hit)) args->valid[i] = 0;
  }
}

void reject_odd_primitives(const RTCFilterFunctionNArguments* args) {
  for_each_lane(args, [](Context&, const RTCRay&, const RTCHit& hit) { return hit.primID % 2 == 0; });
}

/// By where on the triangle, and by which mesh the user pointer says it is.
void reject_checkers(const RTCFilterFunctionNArguments* args) {
  const unsigned mesh = *static_cast<const unsigned*>(args->geometryUserPtr);
  for_each_lane(args, [mesh](Context& context, const RTCRay&, const RTCHit& hit) {
    if (mesh != hit.geomID) ++context.wrong;
    return (static_cast<int>(std::floor(hit.u * 5)) + static_cast<int>(std::floor(hit.v * 5))) % 2 == 0;
  });
}

void collect_all(const RTCFilterFunctionNArguments* args) {
  for_each_lane(args, [](Context& context, const RTCRay&, const RTCHit& hit) {
    context.seen.insert({hit.geomID, hit.primID});
    return false;
  });
}

void accept_and_collect(const RTCFilterFunctionNArguments* args) {
  for_each_lane(args, [](Context& context, const RTCRay&, const RTCHit& hit) {
    context.seen.insert({hit.geomID, hit.primID});
    return true;
  });
}

void reject_every_third(const RTCFilterFunctionNArguments* args) {
  for_each_lane(args, [](Context&, const RTCRay&, const RTCHit& hit) { return hit.primID % 3 != 0; });
}

class PluginFilters : public testing::Test {
 protected:
  void SetUp() override {
    meshes_ = {triangle_soup(1, 100, 1), triangle_soup(2, 100, 4), triangle_soup(3, 100, 9)};
    for (unsigned i = 0; i < 3; ++i) meshes_[i].user_ptr = &numbers_[i];
  }

  /// The same hits on `count` random rays with the query's options, closest and any hit.
  void expect_same(const QueryOptions& options, unsigned count = 2000) {
    const ScenePair pair = scene_pair(device_, meshes_);
    Random random(11);
    unsigned hits = 0, calls = 0;
    for (unsigned i = 0; i < count; ++i) {
      const RTCRayHit ray = random_ray(random);
      Context native, own, direct;
      const auto with = [&](Context& context) {
        QueryOptions result = options;
        result.context = &context.embree;
        return result;
      };
      const RTCRayHit expected = intersect(pair.native.get(), ray, with(native));
      ASSERT_NO_FATAL_FAILURE(expect_same_hit(expected, intersect(pair.own.get(), ray, with(own))));
      const bool occluded = is_occluded(pair.native.get(), ray, with(native));
      ASSERT_EQ(occluded, is_occluded(pair.own.get(), ray, with(own)));
      ASSERT_NO_FATAL_FAILURE(
          expect_same_hit(expected, intersect_directly(pair.geometry.get(), ray, with(direct))));
      ASSERT_EQ(occluded, is_occluded_directly(pair.geometry.get(), ray, with(direct)));
      ASSERT_EQ(own.wrong, 0u);
      ASSERT_EQ(direct.wrong, 0u);
      ASSERT_EQ(direct.calls, own.calls);
      hits += expected.hit.geomID != RTC_INVALID_GEOMETRY_ID;
      calls += own.calls;
    }
    EXPECT_GT(hits, count / 20);
    EXPECT_GT(calls, count / 2);
  }

  Device device_ = new_device();
  std::vector<TestMesh> meshes_;
  unsigned numbers_[3] = {0, 1, 2};
};

TEST_F(PluginFilters, OfOneMesh) {
  meshes_[1].intersect_filter = meshes_[1].occluded_filter = reject_odd_primitives;
  expect_same({});
}

TEST_F(PluginFilters, OfAllMeshesWithTheirUserPointers) {
  for (TestMesh& mesh : meshes_) mesh.intersect_filter = mesh.occluded_filter = reject_checkers;
  expect_same({});
}

TEST_F(PluginFilters, OnlyForClosestHit) {
  for (TestMesh& mesh : meshes_) mesh.intersect_filter = reject_odd_primitives;
  expect_same({});
}

TEST_F(PluginFilters, OnlyForAnyHit) {
  for (TestMesh& mesh : meshes_) mesh.occluded_filter = reject_odd_primitives;
  expect_same({});
}

TEST_F(PluginFilters, OfTheQuery) {
  expect_same({.filter = reject_every_third});
}

TEST_F(PluginFilters, OfMeshesAndThenOfTheQuery) {
  meshes_[0].intersect_filter = meshes_[0].occluded_filter = reject_checkers;
  meshes_[2].intersect_filter = meshes_[2].occluded_filter = reject_odd_primitives;
  expect_same({.filter = reject_every_third});
}

TEST_F(PluginFilters, TheQuerysFilterSeesOnlyWhatTheMeshsAccepted) {
  for (TestMesh& mesh : meshes_) mesh.intersect_filter = mesh.occluded_filter = reject_odd_primitives;
  const ScenePair pair = scene_pair(device_, meshes_);
  Random random(3);
  for (unsigned i = 0; i < 500; ++i) {
    Context context;
    intersect(pair.own.get(), random_ray(random), {.context = &context.embree, .filter = collect_all});
    for (const auto& [geometry, primitive] : context.seen) EXPECT_EQ(primitive % 2, 0u);
  }
}

TEST_F(PluginFilters, ThatRejectEverythingSeeEveryHit) {
  for (TestMesh& mesh : meshes_) mesh.intersect_filter = mesh.occluded_filter = collect_all;
  const ScenePair pair = scene_pair(device_, meshes_);
  Random random(4);
  std::size_t candidates = 0;
  for (unsigned i = 0; i < 2000; ++i) {
    const RTCRayHit ray = random_ray(random);
    Context native, own, occlusion;
    intersect(pair.native.get(), ray, {.context = &native.embree});
    const RTCRayHit after = intersect(pair.own.get(), ray, {.context = &own.embree});
    EXPECT_EQ(after.ray.tfar, ray.ray.tfar);
    EXPECT_EQ(after.hit.geomID, RTC_INVALID_GEOMETRY_ID);
    EXPECT_FALSE(is_occluded(pair.own.get(), ray, {.context = &occlusion.embree}));
    ASSERT_EQ(native.seen, own.seen) << i;
    ASSERT_EQ(native.seen, occlusion.seen) << i;
    candidates += own.seen.size();
  }
  EXPECT_GT(candidates, 2000u);
}

void check_arguments(const RTCFilterFunctionNArguments* args) {
  auto& context = *reinterpret_cast<Context*>(args->context);
  auto& ray = *reinterpret_cast<ExtendedRay*>(args->ray);
  ++context.calls;
  const bool right = args->N == 1 && ray.magic == 0xBEEF && args->valid[0] == -1 &&
                     std::fabs(ray.embree.ray.tfar - 10) < 1e-4f && RTCHitN_primID(args->hit, 1, 0) == 0 &&
                     ray.embree.hit.geomID == RTC_INVALID_GEOMETRY_ID;
  if (!right || context.magic != 0xC0FFEE) ++context.wrong;
  if (args->geometryUserPtr != nullptr) args->valid[0] = 0;
}

TEST(PluginFilterArguments, AreTheApplicationsContextAndRayWithTheCandidatesDistance) {
  const Device device = new_device();
  std::vector<TestMesh> meshes{flat_triangle(0, 3)};
  meshes[0].intersect_filter = check_arguments;
  int reject = 0;
  for (void* const user_ptr : {static_cast<void*>(nullptr), static_cast<void*>(&reject)}) {
    meshes[0].user_ptr = user_ptr;
    const ScenePair pair = scene_pair(device, meshes);
    for (const RTCScene scene : {pair.native.get(), pair.own.get()}) {
      Context context;
      ExtendedRay ray{ray_down(.1f, .1f, .5f)};
      ray.embree.ray.tfar = 99;
      intersect_one(scene, ray.embree, {.context = &context.embree});
      EXPECT_EQ(context.calls, 1u);
      EXPECT_EQ(context.wrong, 0u);
      // Some of Embree's instruction sets round the distance otherwise; what stood there comes back as it
      // was.
      if (user_ptr == nullptr) {
        EXPECT_FLOAT_EQ(ray.embree.ray.tfar, 10.0f);
      } else {
        EXPECT_EQ(ray.embree.ray.tfar, 99.0f);
      }
    }
  }
}

void rewrite_hit(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    RTCHitN_u(args->hit, args->N, i) = .125f;
    RTCHitN_primID(args->hit, args->N, i) = 4711;
  }
}

TEST(PluginFilterArguments, WhatAFilterWritesIntoTheHitIsReported) {
  const Device device = new_device();
  std::vector<TestMesh> meshes{flat_triangle(0, 3)};
  meshes[0].intersect_filter = rewrite_hit;
  const ScenePair pair = scene_pair(device, meshes);
  const RTCRayHit native = intersect(pair.native.get(), ray_down(.1f, .1f, .5f));
  EXPECT_EQ(native.hit.primID, 4711u);
  expect_same_hit(native, intersect(pair.own.get(), ray_down(.1f, .1f, .5f)));
}

/// Keeps the two nearest hits: accepts with tfar at the farther of them.
struct NearestTwo {
  Context context;
  std::map<float, unsigned> hits;
};

void keep_nearest_two(const RTCFilterFunctionNArguments* args) {
  auto& nearest = *reinterpret_cast<NearestTwo*>(args->context);
  nearest.hits[RTCRayN_tfar(args->ray, args->N, 0)] = RTCHitN_primID(args->hit, args->N, 0);
  if (nearest.hits.size() > 2) nearest.hits.erase(std::prev(nearest.hits.end()));
  if (nearest.hits.size() < 2) {
    args->valid[0] = 0;
  } else {
    RTCRayN_tfar(args->ray, args->N, 0) = nearest.hits.rbegin()->first;
  }
}

TEST(PluginFilterArguments, AFilterMayLeaveAnotherDistanceToCollectSeveralHits) {
  const Device device = new_device();
  std::vector<TestMesh> meshes{triangle_soup(1, 400, 5)};
  meshes[0].intersect_filter = keep_nearest_two;
  const ScenePair pair = scene_pair(device, meshes);
  Random random(2);
  for (unsigned i = 0; i < 2000; ++i) {
    const RTCRayHit ray = random_ray(random);
    NearestTwo native, own;
    const RTCRayHit expected = intersect(pair.native.get(), ray, {.context = &native.context.embree});
    const RTCRayHit found = intersect(pair.own.get(), ray, {.context = &own.context.embree});
    ASSERT_EQ(native.hits.size(), own.hits.size());
    for (auto a = native.hits.begin(), b = own.hits.begin(); a != native.hits.end(); ++a, ++b) {
      ASSERT_EQ(a->second, b->second);
    }
    if (own.hits.size() == 2) {
      EXPECT_NEAR(expected.ray.tfar, found.ray.tfar, 1e-4f * (1 + std::fabs(found.ray.tfar)));
    }
  }
}

template <typename Packet, unsigned N, typename Trace>
void expect_same_filtered_packets(const ScenePair& pair, const QueryOptions& options, Trace&& trace) {
  Random random(N);
  for (unsigned round = 0; round < 2000 / N; ++round) {
    alignas(64) int valid[N];
    Packet native{}, own{};
    for (unsigned i = 0; i < N; ++i) {
      valid[i] = random.below(4) == 0 ? 0 : -1;
      const RTCRayHit ray = random_ray(random);
      for (unsigned m = 0; m < kRayHitMembers; ++m) {
        const float value = reinterpret_cast<const float*>(&ray)[m];
        reinterpret_cast<float*>(&native)[m * N + i] = reinterpret_cast<float*>(&own)[m * N + i] = value;
      }
    }
    Context native_context, own_context;
    QueryOptions of_native = options, of_own = options;
    of_native.context = &native_context.embree;
    of_own.context = &own_context.embree;
    trace(valid, pair.native.get(), native, of_native);
    trace(valid, pair.own.get(), own, of_own);
    ASSERT_EQ(own_context.wrong, 0u);
    for (unsigned i = 0; i < N; ++i) {
      if (valid[i] == 0) continue;
      const RTCRayHit a = rtcGetRayHitFromRayHitN(reinterpret_cast<RTCRayHitN*>(&native), N, i);
      const RTCRayHit b = rtcGetRayHitFromRayHitN(reinterpret_cast<RTCRayHitN*>(&own), N, i);
      ASSERT_NO_FATAL_FAILURE(expect_same_hit(a, b));
    }
  }
}

/// Of all widths, closest and any hit.
void expect_same_filtered_packets(const ScenePair& pair, const QueryOptions& options) {
  const auto closest = [](auto&&... query) { intersect_packet(query...); };
  expect_same_filtered_packets<RTCRayHit4, 4>(pair, options, closest);
  expect_same_filtered_packets<RTCRayHit8, 8>(pair, options, closest);
  expect_same_filtered_packets<RTCRayHit16, 16>(pair, options, closest);
  const auto any = [](auto&&... query) { occluded_packet(query...); };
  expect_same_filtered_packets<RTCRayHit4, 4>(pair, options, any);
  expect_same_filtered_packets<RTCRayHit8, 8>(pair, options, any);
  expect_same_filtered_packets<RTCRayHit16, 16>(pair, options, any);
}

TEST_F(PluginFilters, InPackets) {
  for (TestMesh& mesh : meshes_) mesh.intersect_filter = mesh.occluded_filter = reject_checkers;
  expect_same_filtered_packets(scene_pair(device_, meshes_), {.filter = reject_every_third});
}

TEST_F(PluginFilters, InPacketsInFlight) {
  for (TestMesh& mesh : meshes_) mesh.intersect_filter = mesh.occluded_filter = reject_checkers;
  meshes_.push_back(large_mesh_far_away());
  expect_same_filtered_packets(scene_pair(device_, meshes_), {.filter = reject_every_third});
}

#if RTC_VERSION_MAJOR >= 4

TEST_F(PluginFilters, OfTheQueryForThoseMeshesThatAskForIt) {
  meshes_[0].takes_query_filters = meshes_[2].takes_query_filters = true;
  const QueryOptions options{.filter = reject_every_third, .filters_all_meshes = false};
  expect_same(options);
  expect_same_filtered_packets(scene_pair(device_, meshes_), options);
  meshes_[0].intersect_filter = meshes_[1].occluded_filter = reject_odd_primitives;
  expect_same(options);
  const ScenePair pair = scene_pair(device_, meshes_);
  Random random(5);
  std::set<unsigned> asked;
  for (unsigned i = 0; i < 500; ++i) {
    Context context;
    intersect(pair.own.get(), random_ray(random),
              {.context = &context.embree, .filter = collect_all, .filters_all_meshes = false});
    for (const auto& [geometry, primitive] : context.seen) asked.insert(geometry);
  }
  EXPECT_EQ(asked, (std::set<unsigned>{0, 2}));
}

TEST_F(PluginFilters, OfTheQueryForNoneWhereNoneAsksForIt) {
  const ScenePair pair = scene_pair(device_, meshes_);
  Random random(6);
  for (unsigned i = 0; i < 500; ++i) {
    const RTCRayHit ray = random_ray(random);
    Context context;
    const RTCRayHit hit =
        intersect(pair.own.get(), ray,
                  {.context = &context.embree, .filter = collect_all, .filters_all_meshes = false});
    ASSERT_TRUE(same_bits(hit, intersect(pair.own.get(), ray)));
    ASSERT_EQ(context.calls, 0u);
  }
}

#endif

TEST_F(PluginFilters, OfHitsBelowAnInstanceKnowTheInstance) {
  for (TestMesh& mesh : meshes_) mesh.intersect_filter = accept_and_collect;
  const ScenePair pair = scene_pair(device_, meshes_);
  const Scene top = new_scene(device_);
  const NativeGeometry instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(instance.get(), pair.own.get());
  const float identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  rtcSetGeometryTransform(instance.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, identity);
  rtcCommitGeometry(instance.get());
  rtcAttachGeometryByID(top.get(), instance.get(), 9);
  rtcCommitScene(top.get());
  Random random(12);
  unsigned hits = 0;
  for (unsigned i = 0; i < 300; ++i) {
    Context context;
    const RTCRayHit hit = intersect(top.get(), random_ray(random), {.context = &context.embree});
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    ++hits;
    EXPECT_EQ(hit.hit.instID[0], 9u);
    EXPECT_EQ(context.seen.count({hit.hit.geomID, hit.hit.primID}), 1u);
  }
  EXPECT_GT(hits, 50u);
}

}  // namespace
}  // namespace stbvh::test
