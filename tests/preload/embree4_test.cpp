/// What programs of Embree 4 can ask besides: callbacks and filters that a ray brings, instance arrays.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <vector>

#include "plugin/preload/environment.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/tracked_scene.h"
#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

using test::QueryOptions;

/// A plane of the application's own at `z`, hit wherever a ray crosses it; its user data.
struct Plane {
  float z;
  mutable unsigned asked = 0;
};

void plane_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& plane = *static_cast<const Plane*>(arguments->geometryUserPtr);
  *arguments->bounds_o = RTCBounds{-10, -10, plane.z, 0, 10, 10, plane.z, 0};
}

/// Where lane `i` crosses the plane; negative: nowhere that counts.
float crossing(const Plane& plane, RTCRayN* rays, unsigned size, unsigned i) {
  const float t = (plane.z - RTCRayN_org_z(rays, size, i)) / RTCRayN_dir_z(rays, size, i);
  return t > RTCRayN_tnear(rays, size, i) && t < RTCRayN_tfar(rays, size, i) ? t : -1;
}

void intersect_plane(const RTCIntersectFunctionNArguments* arguments) {
  const auto& plane = *static_cast<const Plane*>(arguments->geometryUserPtr);
  const unsigned size = arguments->N;
  RTCRayN* const rays = RTCRayHitN_RayN(arguments->rayhit, size);
  RTCHitN* const hits = RTCRayHitN_HitN(arguments->rayhit, size);
  for (unsigned i = 0; i < size; ++i) {
    if (arguments->valid[i] == 0) continue;
    ++plane.asked;
    const float t = crossing(plane, rays, size, i);
    if (t < 0) continue;
    RTCRayN_tfar(rays, size, i) = t;
    RTCHitN_geomID(hits, size, i) = arguments->geomID;
    RTCHitN_primID(hits, size, i) = arguments->primID;
    RTCHitN_Ng_x(hits, size, i) = RTCHitN_Ng_y(hits, size, i) = 0;
    RTCHitN_Ng_z(hits, size, i) = 1;
    RTCHitN_u(hits, size, i) = RTCHitN_v(hits, size, i) = 0;
    RTCHitN_instID(hits, size, i, 0) = arguments->context->instID[0];
    RTCHitN_instPrimID(hits, size, i, 0) = arguments->context->instPrimID[0];
  }
}

void occluded_plane(const RTCOccludedFunctionNArguments* arguments) {
  const auto& plane = *static_cast<const Plane*>(arguments->geometryUserPtr);
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) continue;
    ++plane.asked;
    if (crossing(plane, arguments->ray, arguments->N, i) >= 0) {
      RTCRayN_tfar(arguments->ray, arguments->N, i) = -std::numeric_limits<float>::infinity();
    }
  }
}

/// Its callbacks come with the rays, unless it has some of its own.
void add_plane(const Embree& embree, RTCDevice device, RTCScene scene, const Plane& plane,
               bool has_callbacks = false) {
  const RTCGeometry geometry = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  embree.rtcSetGeometryUserPrimitiveCount(geometry, 1);
  embree.rtcSetGeometryBoundsFunction(geometry, plane_bounds, nullptr);
  embree.rtcSetGeometryUserData(geometry, const_cast<Plane*>(&plane));
  if (has_callbacks) {
    embree.rtcSetGeometryIntersectFunction(geometry, intersect_plane);
    embree.rtcSetGeometryOccludedFunction(geometry, occluded_plane);
  }
  attach(embree, scene, geometry);
}

QueryOptions with_plane() {
  QueryOptions options;
  options.intersect = intersect_plane;
  options.occluded = occluded_plane;
  return options;
}

template <typename Packet, unsigned kSize>
void expect_same_packets(const Twice& twice, const std::vector<RTCRayHit>& rays,
                         const QueryOptions& options) {
  alignas(64) int valid[kSize];
  std::fill_n(valid, kSize, -1);
  valid[kSize / 2] = 0;
  for (const RTCRayHit& ray : rays) {
    alignas(64) Packet own = packet_of<Packet, kSize>(ray), reference = own;
    intersect_packet(valid, twice.our_scene, own, options);
    intersect_packet(valid, twice.native_scene, reference, options);
    for (unsigned i = 0; i < kSize; ++i) {
      if (valid[i] == 0) continue;
      ASSERT_EQ(own.hit.geomID[i], reference.hit.geomID[i]);
      ASSERT_NEAR(own.ray.tfar[i], reference.ray.tfar[i],
                  own.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? 0 : 1e-3f);
    }
    own = reference = packet_of<Packet, kSize>(ray);
    occluded_packet(valid, twice.our_scene, own, options);
    occluded_packet(valid, twice.native_scene, reference, options);
    for (unsigned i = 0; i < kSize; ++i) {
      if (valid[i] == 0) continue;
      ASSERT_EQ(own.ray.tfar[i] < 0, reference.ray.tfar[i] < 0);
    }
  }
}

/// One by one and in packets.
void expect_same(const Twice& twice, const QueryOptions& options) {
  const std::vector<RTCRayHit> rays = random_rays(7, 400);
  unsigned hit_count = 0;
  for (const RTCRayHit& ray : rays) {
    RTCRayHit own = ray, reference = ray;
    intersect_one(twice.our_scene, own, options);
    intersect_one(twice.native_scene, reference, options);
    expect_same_hit(own, reference);
    if (::testing::Test::HasFatalFailure()) return;
    hit_count += reference.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
    RTCRay own_shadow = ray.ray, shadow = ray.ray;
    occluded_one(twice.our_scene, own_shadow, options);
    occluded_one(twice.native_scene, shadow, options);
    ASSERT_EQ(own_shadow.tfar < 0, shadow.tfar < 0);
  }
  EXPECT_GT(hit_count, rays.size() / 10);
  expect_same_packets<RTCRayHit4, 4>(twice, rays, options);
  expect_same_packets<RTCRayHit8, 8>(twice, rays, options);
  expect_same_packets<RTCRayHit16, 16>(twice, rays, options);
}

TEST(PreloadCallbacksOfQueries, AreAskedForTheApplicationsGeometriesOnly) {
  const Mesh meshes[] = {triangle_soup(1, 150, 3), triangle_soup(2, 100, 1)};
  const Plane planes[2] = {{0.25f}, {0.25f}};
  Twice twice;
  for (const Mesh& mesh : meshes) twice.add(mesh);
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    add_plane(embree, device, scene, planes[scene == twice.our_scene ? 0 : 1]);
  });
  twice.commit();
  ASSERT_TRUE(is_taken_over(twice.our_scene));
  EXPECT_FALSE(answers_alone(twice.our_scene));
  expect_same(twice, with_plane());
  EXPECT_GT(planes[0].asked, 0u);
}

TEST(PreloadCallbacksOfQueries, ReachOursThroughInstancesAndPlanesThatForwardRays) {
  const Mesh mesh = triangle_soup(3, 200, 5);
  const Plane planes[2] = {{-0.5f}, {-0.5f}};
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCScene inner = embree.rtcNewScene(device);
    attach(embree, inner, new_mesh(embree, device, mesh));
    add_plane(embree, device, inner, planes[scene == twice.our_scene ? 0 : 1]);
    embree.rtcCommitScene(inner);
    const RTCGeometry instance = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    embree.rtcSetGeometryInstancedScene(instance, inner);
    const float matrix[12] = {1, 0, 0, 0.1f, 0, 1, 0, 0, 0, 0, 1, 0.2f};
    embree.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
    attach(embree, scene, instance);
    embree.rtcReleaseScene(inner);
  });
  twice.commit();
  expect_same(twice, with_plane());
}

/// A scene that the application shows by a user geometry of its own; its user data.
struct Window {
  RTCScene scene;
};

void window_bounds(const RTCBoundsFunctionArguments* arguments) {
  *arguments->bounds_o = RTCBounds{-4, -4, -4, 0, 4, 4, 4, 0};
}

void intersect_window(const RTCIntersectFunctionNArguments* arguments) {
  const auto& window = *static_cast<const Window*>(arguments->geometryUserPtr);
  if (arguments->N == 1 && arguments->valid[0] != 0) {
    auto* const ray = reinterpret_cast<RTCRay*>(arguments->rayhit);
    rtcForwardIntersect1(arguments, window.scene, ray, arguments->geomID);
  }
}

TEST(PreloadCallbacksOfQueries, AreKeptWhenRaysAreForwarded) {
  const Mesh mesh = triangle_soup(4, 200, 3);
  Window windows[2];
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    Window& window = windows[scene == twice.our_scene ? 0 : 1];
    window.scene = embree.rtcNewScene(device);
    attach(embree, window.scene, new_mesh(embree, device, mesh));
    embree.rtcCommitScene(window.scene);
    const RTCGeometry geometry = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    embree.rtcSetGeometryUserPrimitiveCount(geometry, 1);
    embree.rtcSetGeometryBoundsFunction(geometry, window_bounds, nullptr);
    embree.rtcSetGeometryUserData(geometry, &window);
    attach(embree, scene, geometry);
  });
  twice.commit();
  // Another scene has the group: this one has none.
  QueryOptions options;
  options.intersect = intersect_window;
  unsigned hit_count = 0;
  for (const RTCRayHit& ray : random_rays(9, 500)) {
    RTCRayHit own = ray, reference = ray;
    intersect_one(twice.our_scene, own, options);
    intersect_one(twice.native_scene, reference, options);
    expect_same_hit(own, reference);
    hit_count += own.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
  }
  EXPECT_GT(hit_count, 50u);
  EXPECT_TRUE(is_taken_over(windows[0].scene));
  ours().rtcReleaseScene(windows[0].scene);
  native().rtcReleaseScene(windows[1].scene);
}

/// Rejects every other triangle.
void reject_odd(const RTCFilterFunctionNArguments* arguments) {
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (RTCHitN_primID(arguments->hit, arguments->N, i) % 2 == 1) arguments->valid[i] = 0;
  }
}

/// Rejects every third.
void reject_third(const RTCFilterFunctionNArguments* arguments) {
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (RTCHitN_primID(arguments->hit, arguments->N, i) % 3 == 0) arguments->valid[i] = 0;
  }
}

TEST(PreloadFiltersOfQueries, RunOnAllMeshesOrOnThoseThatTakeThem) {
  const Mesh meshes[] = {triangle_soup(5, 150, 3), triangle_soup(6, 150, 2)};
  for (const bool has_still : {false, true}) {    // answered without Embree, and with it
    const Mesh still = triangle_soup(8, 500, 1);  // more than move
    Twice twice;
    twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
      embree.rtcSetSceneFlags(scene, test::kSceneTakesQueryFilters);
      for (unsigned i = 0; i < 2; ++i) {
        const RTCGeometry geometry = new_mesh(embree, device, meshes[i]);
        embree.rtcSetGeometryEnableFilterFunctionFromArguments(geometry, i == 0);
        if (i == 0) embree.rtcSetGeometryIntersectFilterFunction(geometry, reject_third);
        attach(embree, scene, geometry);
      }
      if (has_still) attach(embree, scene, new_mesh(embree, device, still));
    });
    twice.commit();
    EXPECT_EQ(answers_alone(twice.our_scene), !has_still || preload::environment().all_triangles);
    for (const bool all : {false, true}) {
      QueryOptions options;
      options.filter = reject_odd;
      options.filters_all_meshes = all;
      expect_same(twice, options);
    }
    expect_same(twice, {});
  }
}

TEST(PreloadFiltersOfQueries, RunWithoutTheScenesFlagWhereAMeshHasOneOrTakesThem) {
  const Mesh mesh = triangle_soup(15, 150, 3), other = triangle_soup(16, 50, 2);
  for (const bool has_filter : {false, true}) {
    Twice twice;
    twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
      const RTCGeometry geometry = new_mesh(embree, device, mesh);
      if (has_filter) {
        embree.rtcSetGeometryIntersectFilterFunction(geometry, reject_third);
        embree.rtcSetGeometryOccludedFilterFunction(geometry, reject_third);
      } else {
        embree.rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
      }
      attach(embree, scene, geometry);
      attach(embree, scene, new_mesh(embree, device, other));
    });
    twice.commit();
    for (const bool all : {false, true}) {
      QueryOptions options;
      options.filter = reject_odd;
      options.filters_all_meshes = all;
      expect_same(twice, options);
    }
  }
}

TEST(PreloadInstanceArrays, OfOneSceneAnswerPointQueries) {
  const Mesh mesh = triangle_soup(17, 100, 3);
  std::vector<float> transforms;
  for (const float x : {-1.0f, 0.0f, 1.0f}) {
    for (const float m : {1.0f, 0.0f, 0.0f, x, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f}) {
      transforms.push_back(m);
    }
  }
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCScene inner = embree.rtcNewScene(device);
    attach(embree, inner, new_mesh(embree, device, mesh));
    embree.rtcCommitScene(inner);
    const RTCGeometry array = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE_ARRAY);
    embree.rtcSetGeometryInstancedScene(array, inner);
    embree.rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_TRANSFORM, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                                      transforms.data(), 0, 48, 3);
    attach(embree, scene, array);
    embree.rtcReleaseScene(inner);
  });
  twice.commit();
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(19, 1000));
  unsigned asked[2] = {}, side = 0;
  twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
    RTCPointQuery query{0, 0, 0, 0, 2};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const auto count = [](RTCPointQueryFunctionArguments* arguments) {
      ++*static_cast<unsigned*>(arguments->userPtr);
      return false;
    };
    embree.rtcPointQuery(scene, &query, &context, count, &asked[side++]);
  });
  EXPECT_GT(asked[1], 100u);
  EXPECT_EQ(asked[0], asked[1]);
}

TEST(PreloadInstanceArrays, ShowOurMeshesAndAnswerPointQueries) {
  const Mesh meshes[2] = {triangle_soup(11, 150, 3), triangle_soup(12, 100, 2)};
  constexpr unsigned kInstances = 5;
  std::vector<unsigned> shown{0, 1, 1, 0, 1};
  std::vector<std::vector<float>> transforms(2);
  for (unsigned step = 0; step < 2; ++step) {
    for (unsigned i = 0; i < kInstances; ++i) {
      const float x = 0.8f * static_cast<float>(i) - 1.6f, y = 0.2f * static_cast<float>(step);
      for (const float m : {1.0f, 0.0f, 0.0f, x, 0.0f, 1.0f, 0.0f, y, 0.0f, 0.0f, 1.0f, 0.0f}) {
        transforms[step].push_back(m);
      }
    }
  }
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    RTCScene inner[2];
    for (unsigned i = 0; i < 2; ++i) {
      inner[i] = embree.rtcNewScene(device);
      attach(embree, inner[i], new_mesh(embree, device, meshes[i]));
      embree.rtcCommitScene(inner[i]);
    }
    const RTCGeometry array = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE_ARRAY);
    embree.rtcSetGeometryInstancedScenes(array, inner, 2);
    embree.rtcSetGeometryTimeStepCount(array, 2);
    embree.rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, shown.data(), 0, 4,
                                      kInstances);
    for (unsigned step = 0; step < 2; ++step) {
      embree.rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_TRANSFORM, step, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                                        transforms[step].data(), 0, 48, kInstances);
    }
    attach(embree, scene, array);
    for (const RTCScene one : inner) embree.rtcReleaseScene(one);
  });
  twice.commit();
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(13, 3000));

  // Each primitive that a point query is asked about, in any order.
  struct Asked {
    std::vector<std::array<unsigned, 4>> primitives;
  };
  const auto note = [](RTCPointQueryFunctionArguments* arguments) {
    const RTCPointQueryContext& context = *arguments->context;
    static_cast<Asked*>(arguments->userPtr)
        ->primitives.push_back(
            {context.instID[0], context.instPrimID[0], arguments->geomID, arguments->primID});
    return false;
  };
  Random random(3);
  std::size_t count = 0;
  for (int i = 0; i < 50; ++i) {
    Asked asked[2];
    const RTCPointQuery point{random.between(-2, 2), random.between(-1, 1), random.between(-1, 1), 0, 0.3f};
    unsigned side = 0;
    twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
      RTCPointQuery query = point;
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      embree.rtcPointQuery(scene, &query, &context, note, &asked[side++]);
    });
    for (Asked& a : asked) std::sort(a.primitives.begin(), a.primitives.end());
    EXPECT_EQ(asked[0].primitives, asked[1].primitives);
    count += asked[1].primitives.size();
  }
  EXPECT_GT(count, 50u);
}

/// With Embree 4.4 and later, or with other_embree/later_functions.c.
class PreloadLaterFunctions : public ::testing::Test {
 protected:
  void SetUp() override {
    if (preload::real().rtcTraversableIntersect1 == nullptr) GTEST_SKIP() << "this Embree has none of them";
  }
};

/// As new_mesh, with buffers for the host and another device.
RTCGeometry new_mesh_for_two(RTCDevice device, const Mesh& mesh) {
  const RTCGeometry geometry = ours().rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto step_count = static_cast<unsigned>(mesh.steps.size());
  ours().rtcSetGeometryTimeStepCount(geometry, step_count);
  ours().rtcSetGeometryMask(geometry, mesh.mask);
  rtcSetSharedGeometryBufferHostDevice(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                       mesh.indices.data(), nullptr, 0, 12, mesh.triangle_count());
  for (unsigned step = 0; step < step_count; ++step) {
    void* vertices = nullptr;
    rtcSetNewGeometryBufferHostDevice(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, 12,
                                      mesh.vertex_count(), &vertices, nullptr);
    std::memcpy(vertices, mesh.steps[step].data(), 12 * mesh.vertex_count());
  }
  return geometry;
}

TEST_F(PreloadLaterFunctions, AnswerAsThePlainOnes) {
  const Mesh mesh = triangle_soup(41, 200, 3);
  const Plane plane{0.1f};
  for (const bool alone : {true, false}) {
    Twice twice;
    attach(ours(), twice.our_scene, new_mesh_for_two(twice.our_device, mesh));
    if (!alone) add_plane(ours(), twice.our_device, twice.our_scene, plane);
    twice.commit();
    ASSERT_TRUE(is_taken_over(twice.our_scene));
    EXPECT_EQ(answers_alone(twice.our_scene), alone);
    const auto traversable = reinterpret_cast<RTCTraversable>(twice.our_scene);
    const QueryOptions options = with_plane();
    alignas(64) int valid[16];
    std::fill_n(valid, 16, -1);
    for (const RTCRayHit& ray : random_rays(43, 500)) {
      RTCRayHit plain = ray, later = ray;
      intersect_one(twice.our_scene, plain, options);
      rtcTraversableIntersect1(traversable, &later, test::IntersectArguments(options).get());
      expect_same_bits(plain, later);
      plain = later = ray;
      occluded_one(twice.our_scene, plain.ray, options);
      rtcTraversableOccluded1(traversable, &later.ray, test::OccludedArguments(options).get());
      expect_same_bits(plain, later);
      alignas(64) auto plain_packet = packet_of<RTCRayHit16, 16>(ray), later_packet = plain_packet;
      intersect_packet(valid, twice.our_scene, plain_packet, options);
      rtcTraversableIntersect16(valid, traversable, &later_packet, test::IntersectArguments(options).get());
      EXPECT_EQ(std::memcmp(&plain_packet, &later_packet, 64 * test::kRayHitMembers), 0);
    }
    unsigned asked[2] = {};
    const auto count = [](RTCPointQueryFunctionArguments* arguments) {
      ++*static_cast<unsigned*>(arguments->userPtr);
      return false;
    };
    for (unsigned i = 0; i < 2; ++i) {
      RTCPointQuery query{0, 0, 0, 0, 0.5f};
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      if (i == 0) {
        ours().rtcPointQuery(twice.our_scene, &query, &context, count, &asked[i]);
      } else {
        rtcTraversablePointQuery(traversable, &query, &context, count, &asked[i]);
      }
    }
    EXPECT_GT(asked[0], 0u);
    EXPECT_EQ(asked[0], asked[1]);
  }
}

TEST(PreloadErrors, HaveTheMessageOfTheLatest) {
  const Mesh mesh = triangle_soup(31, 100, 3);
  Twice twice;
  twice.add(mesh);
  ours().rtcSetSceneProgressMonitorFunction(
      twice.our_scene, [](void*, double) { return false; }, nullptr);
  ours().rtcCommitScene(twice.our_scene);
  EXPECT_EQ(ours().rtcGetDeviceError(twice.our_device), RTC_ERROR_CANCELLED);
  EXPECT_STREQ(ours().rtcGetDeviceLastErrorMessage(twice.our_device), "progress monitor forced termination");
  // Embree's own, in both.
  std::string messages[2];
  unsigned side = 0;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    embree.rtcDetachGeometry(scene, 77);
    EXPECT_NE(embree.rtcGetDeviceError(device), RTC_ERROR_NONE);
    messages[side++] = embree.rtcGetDeviceLastErrorMessage(device);
  });
  EXPECT_EQ(messages[0], messages[1]);
  EXPECT_NE(messages[0], "");
}

}  // namespace
}  // namespace stbvh::preload_test
