/// The same scene twice: through the preload library, and in Embree alone.
///
/// The tests have the preload library's functions in the program itself, so that they come before Embree's,
/// as under LD_PRELOAD; Embree's own are looked up behind them. Rays find out by their scene whose they are.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <vector>

#include "tests/queries.h"
#include "tests/random.h"

namespace stbvh::preload_test {

struct Embree {
#define STBVH_FUNCTION(name) decltype(&::name) name;
#include "tests/preload/embree_functions.inl"
#undef STBVH_FUNCTION
};

/// What an application calls that has the preload library before its Embree.
const Embree& ours();
/// Embree itself.
const Embree& native();

using test::intersect_one;
using test::intersect_packet;
using test::occluded_one;
using test::occluded_packet;
using test::Random;

struct Position {
  float x, y, z;
};

struct Mesh {
  std::vector<std::uint32_t> indices;
  std::vector<std::vector<Position>> steps;  ///< with one element of padding, which Embree reads
  float start_time = 0, end_time = 1;
  unsigned mask = 0xFFFFFFFFu;

  std::size_t vertex_count() const { return steps[0].size() - 1; }
  std::size_t triangle_count() const { return indices.size() / 3; }
};

/// `triangles` separate triangles around [-1, 1]^3 whose corners wander from step to step.
Mesh triangle_soup(std::uint32_t seed, unsigned triangles, unsigned step_count);
/// A triangle that fills x, y in [-1, 1] at height z, at rest.
Mesh flat_triangle(float z, unsigned step_count = 2);

/// Everything but the commit, in shared buffers.
RTCGeometry new_mesh(const Embree& embree, RTCDevice device, const Mesh& mesh);
RTCGeometry new_mesh(const Embree& embree, RTCDevice device, Mesh&& mesh) = delete;
/// Commits, attaches and releases.
unsigned attach(const Embree& embree, RTCScene scene, RTCGeometry geometry);

/// Whether a structure of ours answers for meshes of this scene, and for all of it.
bool is_taken_over(RTCScene scene);
bool answers_alone(RTCScene scene);

/// A device of each and a scene of each, with the same contents.
class Twice {
 public:
  Twice();
  ~Twice();
  Twice(const Twice&) = delete;
  Twice& operator=(const Twice&) = delete;

  /// Does the same with both.
  void both(const std::function<void(const Embree&, RTCDevice, RTCScene)>& action);
  void add(const Mesh& mesh);
  void add(Mesh&& mesh) = delete;  // shared buffers
  void commit();

  RTCDevice our_device, native_device;
  RTCScene our_scene, native_scene;
};

/// Rays through [-1, 1]^3 from outside at random times.
std::vector<RTCRayHit> random_rays(std::uint32_t seed, unsigned count);

/// Traces the rays in both and compares IDs exactly, numbers within rounding; at least a tenth must hit.
void expect_same_hits(RTCScene our_scene, RTCScene native_scene, const std::vector<RTCRayHit>& rays);

/// Hits that must be the same, and those that must be the same to the bit.
void expect_same_bits(const RTCRayHit& a, const RTCRayHit& b);
void expect_same_hit(const RTCRayHit& ours, const RTCRayHit& native);

/// Of a ray and its hit; in a packet each lies `size` times side by side.
constexpr unsigned kMembers = test::kRayHitMembers;

template <typename Packet, unsigned kSize>
void put(Packet& packet, unsigned lane, const RTCRayHit& ray) {
  for (unsigned m = 0; m < kMembers; ++m) {
    std::memcpy(reinterpret_cast<char*>(&packet) + 4 * (m * kSize + lane),
                reinterpret_cast<const char*>(&ray) + 4 * m, 4);
  }
}

template <typename Packet, unsigned kSize>
RTCRayHit get(const Packet& packet, unsigned lane) {
  RTCRayHit ray;
  for (unsigned m = 0; m < kMembers; ++m) {
    std::memcpy(reinterpret_cast<char*>(&ray) + 4 * m,
                reinterpret_cast<const char*>(&packet) + 4 * (m * kSize + lane), 4);
  }
  return ray;
}

/// Of a packet: the same ray, moved a little, in each lane.
template <typename Packet, unsigned kSize>
Packet packet_of(const RTCRayHit& ray) {
  Packet packet;
  for (unsigned i = 0; i < kSize; ++i) {
    RTCRayHit lane = ray;
    lane.ray.org_x += 0.01f * static_cast<float>(i);
    put<Packet, kSize>(packet, i, lane);
  }
  return packet;
}

RTCRayHit ray_along_z(float x, float y, float time);
bool hits(RTCScene scene, float x, float y, float time, unsigned mask = 0xFFFFFFFFu);
unsigned geom_id_hit(RTCScene scene, float x, float y, float time);

}  // namespace stbvh::preload_test
