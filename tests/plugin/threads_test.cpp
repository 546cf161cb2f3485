// Queries on many threads, builds of different geometries at once, and the caller's floating-point state.
#include <xmmintrin.h>

#include <cstring>
#include <thread>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

void keep_some(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (RTCHitN_primID(args->hit, args->N, i) % 3 == 0) args->valid[i] = 0;
  }
}

std::vector<RTCRayHit> trace(RTCScene scene, std::uint32_t seed) {
  Random random(seed);
  std::vector<RTCRayHit> hits;
  for (unsigned i = 0; i < 3000; ++i) hits.push_back(intersect(scene, random_ray(random)));
  return hits;
}

TEST(PluginThreads, QueriesAtOnce) {
  const Device device = new_device();
  std::vector<TestMesh> meshes{triangle_soup(1, 200, 5), triangle_soup(2, 200, 1)};
  meshes[0].intersect_filter = keep_some;
  const ScenePair pair = scene_pair(device, meshes);
  const std::vector<RTCRayHit> expected = trace(pair.own.get(), 1);
  std::vector<std::vector<RTCRayHit>> found(4);
  std::vector<std::thread> threads;
  for (auto& hits : found) threads.emplace_back([&] { hits = trace(pair.own.get(), 1); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& hits : found) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      ASSERT_EQ(std::memcmp(&hits[i].hit, &expected[i].hit, 8 * sizeof(float)), 0);
      ASSERT_EQ(hits[i].ray.tfar, expected[i].ray.tfar);
    }
  }
}

TEST(PluginThreads, GeometriesBuiltAtOnce) {
  const Device device = new_device();
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < 4; ++i) {
    threads.emplace_back([&device, i] {
      const ScenePair pair = scene_pair(device, {triangle_soup(i, 300, 3 + i)});
      expect_same_hits(pair.native.get(), pair.own.get(), 300, i);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(PluginThreads, TheCallersFloatingPointStateIsKept) {
  const Device device = new_device();
  const std::vector<TestMesh> meshes{triangle_soup(1, 200, 5), triangle_soup(2, 200, 1)};
  const unsigned original = _mm_getcsr();
  const unsigned flush = 0x8040;  // flush to zero, denormals are zero
  for (const unsigned state : {original & ~flush, original | flush}) {
    _mm_setcsr(state);
    const OwnGeometry geometry = own_geometry(device, meshes);
    EXPECT_EQ(_mm_getcsr() & ~0x3Fu, state & ~0x3Fu);
    const ScenePair pair = scene_pair(device, meshes);
    _mm_setcsr(state);
    expect_same_hits(pair.native.get(), pair.own.get(), 500, 1);
    EXPECT_EQ(_mm_getcsr() & ~0x3Fu, state & ~0x3Fu);
    _mm_setcsr(original);
  }
}

}  // namespace
}  // namespace stbvh::test
