/// What rays see: hit data, packets and streams, masks, times, filters.
#include <atomic>
#include <cstring>
#include <limits>

#include "tests/packet_widths.h"
#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

/// Three moving meshes with different steps, one still one in between.
struct FourMeshes {
  Mesh meshes[4] = {triangle_soup(1, 120, 3), triangle_soup(2, 100, 1), triangle_soup(3, 150, 9),
                    triangle_soup(4, 80, 2)};
};

TEST(PreloadHits, AreThoseOfEmbreeInAllKindsOfScenes) {
  const FourMeshes f;
  for (const RTCSceneFlags flags :
       {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_ROBUST, RTC_SCENE_FLAG_COMPACT, RTC_SCENE_FLAG_DYNAMIC}) {
    for (const RTCBuildQuality quality :
         {RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_HIGH}) {
      Twice twice;
      twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
        embree.rtcSetSceneFlags(scene, flags);
        embree.rtcSetSceneBuildQuality(scene, quality);
      });
      for (const Mesh& mesh : f.meshes) twice.add(mesh);
      twice.commit();
      EXPECT_TRUE(is_taken_over(twice.our_scene));
      expect_same_hits(twice.our_scene, twice.native_scene, random_rays(11, 2000));
    }
  }
}

TEST(PreloadHits, NoneForRaysThatLeaveALargeGround) {
  Random random(6);
  for (const float size : {10.0f, 1e3f, 1e4f, 1e5f, 1e6f}) {
    Mesh ground;
    ground.indices = {0, 1, 2, 0, 2, 3};
    ground.steps.assign(2, {{-size, 0, -size}, {size, 0, -size}, {size, 0, size}, {-size, 0, size}, {}});
    Twice twice;
    twice.add(ground);
    twice.commit();
    ASSERT_TRUE(is_taken_over(twice.our_scene));
    for (int i = 0; i < 20000; ++i) {
      constexpr float kHeights[] = {0, 1e-4f, 1e-3f, 1e-2f};
      RTCRayHit ray = ray_along_z(0.9f * random.between(-size, size), kHeights[i % 4], random.unit());
      ray.ray.org_z = 0.9f * random.between(-size, size);
      ray.ray.dir_x = random.between(-1, 1);
      ray.ray.dir_y = random.between(1e-6f, 1);
      ray.ray.dir_z = random.between(-1, 1);
      intersect_one(twice.our_scene, ray);
      ASSERT_EQ(ray.hit.geomID, RTC_INVALID_GEOMETRY_ID) << size;
    }
  }
}

template <typename Packet, unsigned kSize>
void expect_same_packets(const Twice& twice) {
  const std::vector<RTCRayHit> rays = random_rays(17, 64 * kSize);
  Random random(5);
  for (unsigned first = 0; first < rays.size(); first += kSize) {
    alignas(64) Packet packets[2];
    alignas(64) int valid[kSize];
    for (unsigned i = 0; i < kSize; ++i) {
      valid[i] = random.unit() < 0.7f ? -1 : 0;
      for (Packet& packet : packets) put<Packet, kSize>(packet, i, rays[first + i]);
    }
    intersect_packet(valid, twice.our_scene, packets[0]);
    intersect_packet(valid, twice.native_scene, packets[1]);
    for (unsigned i = 0; i < kSize; ++i) {
      const RTCRayHit hit = get<Packet, kSize>(packets[0], i);
      expect_same_hit(hit, get<Packet, kSize>(packets[1], i));
      if (valid[i] != 0 || !test::is_native_width<kSize>(twice.native_device)) continue;
      EXPECT_EQ(std::memcmp(&hit, &rays[first + i], 4 * kMembers), 0);
    }
  }
}

TEST(PreloadHits, OfPacketsWithInactiveLanes) {
  const FourMeshes f;
  Twice twice;
  for (const Mesh& mesh : f.meshes) twice.add(mesh);
  twice.commit();
  expect_same_packets<RTCRayHit4, 4>(twice);
  expect_same_packets<RTCRayHit8, 8>(twice);
  expect_same_packets<RTCRayHit16, 16>(twice);
}

#if RTC_VERSION_MAJOR < 4

TEST(PreloadHits, OfStreams) {
  const FourMeshes f;
  Twice twice;
  for (const Mesh& mesh : f.meshes) twice.add(mesh);
  twice.commit();
  std::vector<RTCRayHit> own = random_rays(23, 3000), reference = own;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1M(twice.our_scene, &context, own.data(), 3000, sizeof(RTCRayHit));
  rtcIntersect1M(twice.native_scene, &context, reference.data(), 3000, sizeof(RTCRayHit));
  for (unsigned i = 0; i < own.size(); ++i) expect_same_hit(own[i], reference[i]);
}

#endif

TEST(PreloadHits, MasksAreThoseOfTheMeshes) {
  Mesh near = flat_triangle(0), far = flat_triangle(1);
  near.mask = 1;
  far.mask = 6;
  Twice twice;
  twice.add(near);
  twice.add(far);
  twice.commit();
  for (unsigned mask = 0; mask < 16; ++mask) {
    for (const RTCScene scene : {twice.our_scene, twice.native_scene}) {
      EXPECT_EQ(hits(scene, 0, 0, 0.5f, mask), (mask & 7) != 0) << mask;
    }
  }
}

TEST(PreloadHits, OutsideItsTimeRangeAMeshIsInvisible) {
  Mesh early = flat_triangle(0, 3), late = flat_triangle(1, 5);
  early.end_time = 0.25f;
  late.start_time = 0.5f;
  Twice twice;
  twice.add(early);
  twice.add(late);
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  for (const float time : {0.0f, 0.1f, 0.24f, 0.26f, 0.4f, 0.49f, 0.51f, 0.75f, 1.0f}) {
    EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, time), geom_id_hit(twice.native_scene, 0, 0, time)) << time;
  }
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.1f), 0u);
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.4f), RTC_INVALID_GEOMETRY_ID);
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.6f), 1u);
}

/// The application's own members behind Embree's, which filters of tutorials reach by a cast.
struct WideContext {
  test::QueryContext context;
  std::vector<unsigned> seen;  ///< geomIDs of candidates
};
struct alignas(16) WideRay {
  RTCRayHit ray_hit;
  int accept_from = 0;  ///< rejects as many candidates
};

/// Rejects the first candidates, and writes down what it is given.
void rejecting(const RTCFilterFunctionNArguments* arguments) {
  ASSERT_EQ(arguments->N, 1u);
  auto& context = *reinterpret_cast<WideContext*>(arguments->context);
  auto& ray = *reinterpret_cast<WideRay*>(arguments->ray);
  EXPECT_EQ(*static_cast<int*>(arguments->geometryUserPtr), 1234);
  const unsigned geom_id = RTCHitN_geomID(arguments->hit, 1, 0);
  context.seen.push_back(geom_id);
  // The candidate's distance is in the ray: triangle i lies at z = i.
  EXPECT_FLOAT_EQ(ray.ray_hit.ray.tfar, 100.0f + static_cast<float>(geom_id));
  if (ray.accept_from-- > 0) arguments->valid[0] = 0;
}

class Filters : public ::testing::Test {
 protected:
  Filters() {
    twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
      for (unsigned i = 0; i < 3; ++i) {
        const RTCGeometry geometry = new_mesh(embree, device, meshes[i]);
        embree.rtcSetGeometryIntersectFilterFunction(geometry, rejecting);
        embree.rtcSetGeometryOccludedFilterFunction(geometry, rejecting);
        attach(embree, scene, geometry);
        geometries[&embree == &ours() ? 0 : 1][i] = geometry;
      }
    });
    twice.commit();
    // User data may change after the commit.
    twice.both([&](const Embree& embree, RTCDevice, RTCScene) {
      for (const RTCGeometry g : geometries[&embree == &ours() ? 0 : 1])
        embree.rtcSetGeometryUserData(g, &value);
    });
  }

  WideRay trace(RTCScene scene, int rejected, bool occluded, WideContext& context) {
    context.context = test::new_context();
    WideRay ray;
    ray.ray_hit = ray_along_z(0, 0, 0.3f);
    ray.accept_from = rejected;
    if (occluded) {
      occluded_one(scene, ray.ray_hit.ray, {.context = &context.context});
    } else {
      intersect_one(scene, ray.ray_hit, {.context = &context.context});
    }
    return ray;
  }

  int value = 1234;
  Mesh meshes[3] = {flat_triangle(0, 2), flat_triangle(1, 3), flat_triangle(2, 5)};
  RTCGeometry geometries[2][3];
  Twice twice;
};

TEST_F(Filters, OfMeshesSeeEveryCandidateInTheApplicationsOwnRayAndContext) {
  for (int rejected = 0; rejected < 4; ++rejected) {
    WideContext context;
    const WideRay ray = trace(twice.our_scene, rejected, false, context);
    // In some order, at least those up to the accepted one; nearer than it nothing may be left.
    EXPECT_GE(context.seen.size(), std::min<std::size_t>(3, static_cast<std::size_t>(rejected) + 1));
    WideContext native_context;
    const WideRay reference = trace(twice.native_scene, rejected, false, native_context);
    if (rejected == 0 || rejected == 3) {
      EXPECT_EQ(ray.ray_hit.hit.geomID, reference.ray_hit.hit.geomID);
    }
    if (rejected == 3) {
      EXPECT_EQ(ray.ray_hit.ray.tfar, std::numeric_limits<float>::infinity());
    }
  }
}

TEST_F(Filters, OfOcclusion) {
  for (int rejected = 0; rejected < 4; ++rejected) {
    WideContext context;
    const WideRay ray = trace(twice.our_scene, rejected, true, context);
    EXPECT_EQ(context.seen.size(), std::min<std::size_t>(3, static_cast<std::size_t>(rejected) + 1));
    EXPECT_EQ(ray.ray_hit.ray.tfar < 0, rejected < 3);
  }
}

void reject_all(const RTCFilterFunctionNArguments* arguments) {
  for (unsigned i = 0; i < arguments->N; ++i) arguments->valid[i] = 0;
}

TEST(PreloadFilters, OfQueriesRunOnlyWhereTheSceneAsksForThem) {
  const Mesh mesh = flat_triangle(0);
  for (const bool asks : {false, true}) {
    Twice twice;
    twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
      embree.rtcSetSceneFlags(scene, asks ? test::kSceneTakesQueryFilters : RTC_SCENE_FLAG_NONE);
    });
    twice.add(mesh);
    twice.commit();
    for (const RTCScene scene : {twice.our_scene, twice.native_scene}) {
      if (scene == twice.native_scene && !asks) continue;  // Debian's Embree stops in an assertion
      RTCRayHit ray = ray_along_z(0, 0, 0.5f);
      intersect_one(scene, ray, {.filter = reject_all});
      EXPECT_EQ(ray.hit.geomID == RTC_INVALID_GEOMETRY_ID, asks);
    }
  }
}

TEST(PreloadHits, InstancesReportTheirIds) {
  const Mesh mesh = triangle_soup(9, 200, 4);
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCScene inner = embree.rtcNewScene(device);
    attach(embree, inner, new_mesh(embree, device, mesh));
    embree.rtcCommitScene(inner);
    for (unsigned i = 0; i < 3; ++i) {
      const RTCGeometry instance = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
      embree.rtcSetGeometryInstancedScene(instance, inner);
      embree.rtcSetGeometryTimeStepCount(instance, 2);
      for (unsigned step = 0; step < 2; ++step) {
        const float x = static_cast<float>(i) - 1, y = static_cast<float>(step) * 0.3f;
        const float matrix[12] = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, 0};
        embree.rtcSetGeometryTransform(instance, step, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
      }
      attach(embree, scene, instance);
    }
    embree.rtcReleaseScene(inner);  // the instances keep it
  });
  twice.commit();
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(31, 3000));
}

}  // namespace
}  // namespace stbvh::preload_test
