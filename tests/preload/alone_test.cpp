/// Scenes that are answered without Embree: where nothing is in them that is not ours.
#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <vector>

#include "plugin/preload/environment.h"
#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

using test::QueryOptions;

/// `triangles` of them at rest, where no ray of the tests goes.
Mesh far_away(unsigned triangles) {
  Mesh mesh = triangle_soup(77, triangles, 1);
  for (Position& p : mesh.steps[0]) p.z += 1e6f;
  return mesh;
}

/// The same ray, moved a little, in each lane, in both; one lane is not valid.
template <typename Packet, unsigned kSize>
void expect_same_packets(RTCScene a, RTCScene b, const RTCRayHit& ray) {
  alignas(64) int valid[kSize];
  std::fill_n(valid, kSize, -1);
  valid[kSize / 2] = 0;
  RTCRayHit none = ray;  // Embree 3 does not look at `valid` in packets that it cuts up
  none.ray.tnear = 2;
  none.ray.tfar = 1;
  alignas(64) std::array<Packet, 2> packets;
  packets.fill(packet_of<Packet, kSize>(ray));
  for (Packet& packet : packets) put<Packet, kSize>(packet, kSize / 2, none);
  const auto shadows = packets;
  intersect_packet(valid, a, packets[0]);
  intersect_packet(valid, b, packets[1]);
  EXPECT_EQ(std::memcmp(&packets[0], &packets[1], 4 * kMembers * kSize), 0);
  packets = shadows;
  occluded_packet(valid, a, packets[0]);
  occluded_packet(valid, b, packets[1]);
  EXPECT_EQ(std::memcmp(&packets[0], &packets[1], 4 * kMembers * kSize), 0);
}

TEST(PreloadAlone, AnswersAreThoseThatEmbreeGetsFromUs) {
  const Mesh meshes[2] = {triangle_soup(21, 150, 3), triangle_soup(22, 100, 5)};
  const Mesh far = far_away(300);
  Twice twice;  // the second through us, too, beside something that is Embree's
  const RTCScene mixed = ours().rtcNewScene(twice.our_device);
  for (const Mesh& mesh : meshes) {
    twice.add(mesh);
    attach(ours(), mixed, new_mesh(ours(), twice.our_device, mesh));
  }
  attach(ours(), mixed, new_mesh(ours(), twice.our_device, far));
  ours().rtcCommitScene(mixed);
  EXPECT_FALSE(answers_alone(twice.our_scene)) << "it is not committed";
  twice.commit();
  EXPECT_TRUE(answers_alone(twice.our_scene));
  EXPECT_EQ(answers_alone(mixed), preload::environment().all_triangles);
  for (RTCRayHit ray : random_rays(23, 3000)) {
    ray.ray.tfar = std::min(ray.ray.tfar, 100.0f);
    // Contexts that are handed in are the application's: what stands in them comes out again.
    test::QueryContext context = test::new_context();
    context.instID[0] = 5;
    for (const QueryOptions& options : {QueryOptions{}, QueryOptions{.context = &context}}) {
      RTCRayHit alone = ray, beside = ray;
      intersect_one(twice.our_scene, alone, options);
      intersect_one(mixed, beside, options);
      expect_same_bits(alone, beside);
      alone = beside = ray;
      occluded_one(twice.our_scene, alone.ray, options);
      occluded_one(mixed, beside.ray, options);
      expect_same_bits(alone, beside);
    }
    expect_same_packets<RTCRayHit4, 4>(twice.our_scene, mixed, ray);
    expect_same_packets<RTCRayHit8, 8>(twice.our_scene, mixed, ray);
    expect_same_packets<RTCRayHit16, 16>(twice.our_scene, mixed, ray);
    if (::testing::Test::HasFailure()) break;
  }
  ours().rtcReleaseScene(mixed);
}

TEST(PreloadAlone, UntilSomethingElseIsThere) {
  const Mesh mesh = flat_triangle(1), nearer = flat_triangle(0, 1), far = far_away(3);
  Twice twice;
  twice.add(mesh);
  twice.commit();
  EXPECT_TRUE(answers_alone(twice.our_scene));
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.5f), 0u);
  twice.add(nearer);
  twice.add(far);
  twice.commit();
  EXPECT_EQ(answers_alone(twice.our_scene), preload::environment().all_triangles);
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.5f), 1u);
  twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
    for (const unsigned id : {1u, 2u}) embree.rtcDisableGeometry(embree.rtcGetGeometry(scene, id));
  });
  twice.commit();
  EXPECT_TRUE(answers_alone(twice.our_scene));
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.5f), 0u);
  twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
    embree.rtcDisableGeometry(embree.rtcGetGeometry(scene, 0));
  });
  twice.commit();
  EXPECT_FALSE(answers_alone(twice.our_scene));
  EXPECT_EQ(geom_id_hit(twice.our_scene, 0, 0, 0.5f), RTC_INVALID_GEOMETRY_ID);
}

/// What is at rest is ours too as long as no more of it is there than moves, and nothing else.
TEST(PreloadAlone, WithWhatRestsBesideAsMuchThatMoves) {
  const Mesh moving = triangle_soup(31, 100, 4), still = triangle_soup(32, 100, 1),
             one_more = triangle_soup(33, 1, 1);
  Twice twice;
  twice.add(still);
  twice.add(moving);
  twice.commit();
  EXPECT_TRUE(answers_alone(twice.our_scene));
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(34, 1000));
  const bool all = preload::environment().all_triangles;
  twice.add(one_more);
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  EXPECT_EQ(answers_alone(twice.our_scene), all);
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(35, 1000));
  twice.both([](const Embree& embree, RTCDevice, RTCScene scene) { embree.rtcDetachGeometry(scene, 2); });
  twice.commit();
  EXPECT_TRUE(answers_alone(twice.our_scene));
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(36, 1000));
  // An instance, of an empty scene, is something else.
  twice.both([](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCScene inner = embree.rtcNewScene(device);
    embree.rtcCommitScene(inner);
    const RTCGeometry instance = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    embree.rtcSetGeometryInstancedScene(instance, inner);
    attach(embree, scene, instance);
    embree.rtcReleaseScene(inner);
  });
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  EXPECT_FALSE(answers_alone(twice.our_scene));
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(37, 1000));
}

/// Embree has one switch for it: what is at rest and in another scene too is left to Embree in both.
TEST(PreloadAlone, NotWithWhatRestsInTwoScenes) {
  const Mesh moving = triangle_soup(41, 100, 4), still = flat_triangle(0, 1), higher = flat_triangle(9, 1);
  const RTCDevice device = ours().rtcNewDevice(nullptr);
  const RTCScene first = ours().rtcNewScene(device), second = ours().rtcNewScene(device);
  attach(ours(), first, new_mesh(ours(), device, moving));
  const RTCGeometry shared = new_mesh(ours(), device, still);
  ours().rtcCommitGeometry(shared);
  ours().rtcAttachGeometryByID(first, shared, 7);
  ours().rtcCommitScene(first);
  EXPECT_TRUE(answers_alone(first));
  attach(ours(), second, new_mesh(ours(), device, higher));
  ours().rtcAttachGeometryByID(second, shared, 8);
  const bool all = preload::environment().all_triangles;
  for (int i = 0; i < 2; ++i) {  // in turns
    ours().rtcCommitScene(second);
    ours().rtcCommitScene(first);
    EXPECT_EQ(answers_alone(first), all);
    EXPECT_EQ(geom_id_hit(first, 0.9f, -0.9f, 0.5f), 7u);
    EXPECT_EQ(geom_id_hit(second, 0.9f, -0.9f, 0.5f), 8u);
  }
  ours().rtcReleaseScene(second);
  ours().rtcDisableGeometry(shared);
  ours().rtcEnableGeometry(shared);
  ours().rtcCommitScene(first);
  EXPECT_TRUE(answers_alone(first)) << "it is in one scene again";
  EXPECT_EQ(geom_id_hit(first, 0.9f, -0.9f, 0.5f), 7u);
  ours().rtcReleaseGeometry(shared);
  ours().rtcReleaseScene(first);
  ours().rtcReleaseDevice(device);
}

/// With STBVH_PRELOAD_MAX_BYTES, as a run of its own sets it: what moves fits, and what rests beside it not
/// too.
TEST(PreloadAlone, WhereMemoryIsLimitedWhatMovesGoesFirst) {
  const std::size_t limit = preload::environment().max_bytes;
  if (limit == kNoLimit) GTEST_SKIP() << "no limit";
  const auto triangles = static_cast<unsigned>(limit / 140);
  const Mesh moving = triangle_soup(51, triangles, 3), still = triangle_soup(52, triangles, 1);
  Twice twice;
  twice.add(moving);
  twice.commit();
  ASSERT_TRUE(answers_alone(twice.our_scene)) << "too many for this test";
  twice.add(still);
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  EXPECT_FALSE(answers_alone(twice.our_scene));
  EXPECT_EQ(ours().rtcGetDeviceError(twice.our_device), RTC_ERROR_NONE);
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(53, 1000));
}

TEST(PreloadAlone, FiltersThatThrowAreAnErrorOfTheDevice) {
  const Mesh mesh = flat_triangle(0);
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCGeometry geometry = new_mesh(embree, device, mesh);
    embree.rtcSetGeometryIntersectFilterFunction(
        geometry, [](const RTCFilterFunctionNArguments*) { throw std::bad_alloc(); });
    attach(embree, scene, geometry);
  });
  twice.commit();
  EXPECT_TRUE(answers_alone(twice.our_scene));
  RTCRayHit ray = ray_along_z(0, 0, 0.5f);
  intersect_one(twice.our_scene, ray);
  EXPECT_EQ(ours().rtcGetDeviceError(twice.our_device), RTC_ERROR_OUT_OF_MEMORY);
}

}  // namespace
}  // namespace stbvh::preload_test
