// All query widths, with inactive lanes, and Embree 3's streams; on whatever instruction set Embree uses.
#include <cstring>
#include <limits>
#include <type_traits>

#include "tests/packet_widths.h"
#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

std::vector<TestMesh> meshes_of_all_kinds() {
  std::vector<TestMesh> meshes{triangle_soup(1, 80, 1), triangle_soup(2, 80, 3), triangle_soup(3, 80, 9)};
  meshes[1].mask = 5;
  meshes[2].start_time = .2f;
  meshes[2].end_time = .7f;
  return meshes;
}

/// N rays and hits in the layout of RTCRayHit4, 8 and 16.
template <unsigned N>
struct alignas(64) Packet {
  float members[kRayHitMembers][N];

  RTCRayHitN* lanes() { return reinterpret_cast<RTCRayHitN*>(members); }

  void set(unsigned lane, const RTCRayHit& query) {
    float values[kRayHitMembers];
    std::memcpy(values, &query, sizeof(values));
    for (unsigned m = 0; m < kRayHitMembers; ++m) members[m][lane] = values[m];
  }
  RTCRayHit get(unsigned lane) { return rtcGetRayHitFromRayHitN(lanes(), N, lane); }
};

template <unsigned N>
using RayHitN = std::conditional_t<N == 4, RTCRayHit4, std::conditional_t<N == 8, RTCRayHit8, RTCRayHit16>>;

template <unsigned N>
RayHitN<N>& as_embree(Packet<N>& packet) {
  return reinterpret_cast<RayHitN<N>&>(packet);
}

RTCRayHit random_masked_ray(Random& random) {
  RTCRayHit ray = random_ray(random);
  ray.ray.mask = random.below(3) == 0 ? 2u : 0xFFFFFFFFu;
  return ray;
}

/// How a lane is switched off.
enum class Lane { kOn, kOffByValid, kOffByValidAndDistance };

/// Queries of both scenes with one packet.
template <unsigned N>
struct PacketAnswers {
  Packet<N> before, native, own, native_occlusion, own_occlusion;

  PacketAnswers(const ScenePair& pair, const QueryOptions& options, const int* valid, const Packet<N>& packet)
      : before(packet), native(packet), own(packet), native_occlusion(packet), own_occlusion(packet) {
    intersect_packet(valid, pair.native.get(), as_embree(native), options);
    intersect_packet(valid, pair.own.get(), as_embree(own), options);
    occluded_packet(valid, pair.native.get(), as_embree(native_occlusion), options);
    occluded_packet(valid, pair.own.get(), as_embree(own_occlusion), options);
  }

  void expect_untouched(unsigned lane) {
    const RTCRayHit old = before.get(lane);
    for (Packet<N>* const answer : {&native, &own, &native_occlusion, &own_occlusion}) {
      const RTCRayHit now = answer->get(lane);
      ASSERT_TRUE(same_bits(old, now));
    }
  }

  /// Any hit against closest hits: on SSE2 Embree's own packets of shadow rays hit moving triangles outside
  /// their time range.
  void expect_same(unsigned lane) {
    const RTCRayHit hit = own.get(lane);
    ASSERT_NO_FATAL_FAILURE(expect_same_hit(native.get(lane), hit));
    const bool is_hit = hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    const float tfar = is_hit ? -std::numeric_limits<float>::infinity() : before.get(lane).ray.tfar;
    ASSERT_EQ(own_occlusion.get(lane).ray.tfar, tfar);
  }
};

template <unsigned N>
void expect_same_packets(const Device& device, const ScenePair& pair, const QueryOptions& options) {
  Random random(N);
  for (unsigned round = 0; round < 3000 / N; ++round) {
    alignas(64) int valid[N];
    Lane lanes[N];
    Packet<N> packet;
    for (unsigned i = 0; i < N; ++i) {
      lanes[i] = random.below(3) != 0   ? Lane::kOn
                 : random.below(2) == 0 ? Lane::kOffByValid
                                        : Lane::kOffByValidAndDistance;
      valid[i] = lanes[i] == Lane::kOn ? -1 : 0;
      RTCRayHit ray = random_masked_ray(random);
      if (lanes[i] == Lane::kOffByValidAndDistance) ray.ray.tfar = -1;
      packet.set(i, ray);
    }
    PacketAnswers<N> answers(pair, options, valid, packet);
    for (unsigned i = 0; i < N; ++i) {
      SCOPED_TRACE(testing::Message() << "N " << N << " round " << round << " lane " << i);
      const bool traced =
          lanes[i] == Lane::kOn || (lanes[i] == Lane::kOffByValid && !looks_at_valid<N>(device.get()));
      traced ? answers.expect_same(i) : answers.expect_untouched(i);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(PluginWidths, Packets) {
  const Device device = new_device();
  for (const bool in_flight : {false, true}) {
    std::vector<TestMesh> meshes = meshes_of_all_kinds();
    if (in_flight) meshes.push_back(large_mesh_far_away());
    const ScenePair pair = scene_pair(device, meshes);
    for (const bool coherent : {false, true}) {
      const QueryOptions options{.coherent = coherent};
      expect_same_packets<4>(device, pair, options);
      expect_same_packets<8>(device, pair, options);
      expect_same_packets<16>(device, pair, options);
    }
  }
}

#if RTC_VERSION_MAJOR == 3

class PluginStreams : public testing::Test {
 protected:
  static constexpr unsigned kCount = 1000;

  void SetUp() override {
    Random random(5);
    for (unsigned i = 0; i < kCount; ++i) rays_.push_back(random_masked_ray(random));
    for (const RTCRayHit& ray : rays_) expected_.push_back(intersect(pair_.native.get(), ray));
  }

  void expect_hits(const std::vector<RTCRayHit>& hits) const {
    for (unsigned i = 0; i < kCount; ++i) ASSERT_NO_FATAL_FAILURE(expect_same_hit(expected_[i], hits[i]));
  }

  void expect_occluded(const std::vector<RTCRay>& rays) const {
    for (unsigned i = 0; i < kCount; ++i) {
      const bool hit = expected_[i].hit.geomID != RTC_INVALID_GEOMETRY_ID;
      ASSERT_EQ(rays[i].tfar, hit ? -std::numeric_limits<float>::infinity() : rays_[i].ray.tfar);
    }
  }

  std::vector<RTCRay> plain_rays() const {
    std::vector<RTCRay> rays;
    for (const RTCRayHit& ray : rays_) rays.push_back(ray.ray);
    return rays;
  }

  Device device_ = new_device();
  std::vector<TestMesh> meshes_ = meshes_of_all_kinds();
  ScenePair pair_ = scene_pair(device_, meshes_);
  RTCIntersectContext context_ = new_context();
  std::vector<RTCRayHit> rays_;
  std::vector<RTCRayHit> expected_;
};

TEST_F(PluginStreams, OneM) {
  std::vector<RTCRayHit> hits = rays_;
  rtcIntersect1M(pair_.own.get(), &context_, hits.data(), kCount, sizeof(RTCRayHit));
  expect_hits(hits);
  std::vector<RTCRay> rays = plain_rays();
  rtcOccluded1M(pair_.own.get(), &context_, rays.data(), kCount, sizeof(RTCRay));
  expect_occluded(rays);
}

TEST_F(PluginStreams, OneMPointers) {
  std::vector<RTCRayHit> hits = rays_;
  std::vector<RTCRay> rays = plain_rays();
  std::vector<RTCRayHit*> hit_pointers;
  std::vector<RTCRay*> ray_pointers;
  for (unsigned i = 0; i < kCount; ++i) {
    hit_pointers.push_back(&hits[i]);
    ray_pointers.push_back(&rays[i]);
  }
  rtcIntersect1Mp(pair_.own.get(), &context_, hit_pointers.data(), kCount);
  expect_hits(hits);
  rtcOccluded1Mp(pair_.own.get(), &context_, ray_pointers.data(), kCount);
  expect_occluded(rays);
}

TEST_F(PluginStreams, StructureOfArraysNp) {
  // One array for each member, as RTCRayHitNp wants it.
  std::vector<std::vector<float>> members(20, std::vector<float>(kCount));
  for (unsigned i = 0; i < kCount; ++i) {
    float values[20];
    std::memcpy(values, &rays_[i], sizeof(values));
    for (unsigned m = 0; m < 20; ++m) members[m][i] = values[m];
  }
  const auto collect = [&] {
    std::vector<RTCRayHit> hits(kCount);
    for (unsigned i = 0; i < kCount; ++i) {
      float values[20];
      for (unsigned m = 0; m < 20; ++m) values[m] = members[m][i];
      std::memcpy(static_cast<void*>(&hits[i]), values, sizeof(values));
    }
    return hits;
  };
  const auto f = [&](unsigned m) { return members[m].data(); };
  const auto u = [&](unsigned m) { return reinterpret_cast<unsigned*>(members[m].data()); };
  const RTCRayNp ray{f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7), f(8), u(9), u(10), u(11)};
  const std::vector<float> tfar = members[8];
  rtcOccludedNp(pair_.own.get(), &context_, &ray, kCount);
  std::vector<RTCRay> rays;
  for (const RTCRayHit& hit : collect()) rays.push_back(hit.ray);
  expect_occluded(rays);
  members[8] = tfar;
  const RTCRayHitNp hit{ray, {f(12), f(13), f(14), f(15), f(16), u(17), u(18), {u(19)}}};
  rtcIntersectNp(pair_.own.get(), &context_, &hit, kCount);
  expect_hits(collect());
}

TEST_F(PluginStreams, PacketsNM) {
  constexpr unsigned kWidth = 8;
  std::vector<Packet<kWidth>> packets(kCount / kWidth);
  for (unsigned i = 0; i < kCount; ++i) packets[i / kWidth].set(i % kWidth, rays_[i]);
  rtcIntersectNM(pair_.own.get(), &context_, packets[0].lanes(), kWidth, kCount / kWidth, sizeof(packets[0]));
  std::vector<RTCRayHit> hits;
  for (unsigned i = 0; i < kCount; ++i) hits.push_back(packets[i / kWidth].get(i % kWidth));
  expect_hits(hits);
}

#endif

}  // namespace
}  // namespace stbvh::test
