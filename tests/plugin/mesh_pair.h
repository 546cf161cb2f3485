/// The same meshes as Embree's own triangle geometries and as one geometry of the plugin.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "tests/queries.h"
#include "tests/random.h"

namespace stbvh::test {

struct Position {
  float x, y, z;
};

struct TestMesh {
  std::vector<std::uint32_t> indices;
  std::vector<std::vector<Position>> steps;  ///< with one element of padding, which Embree reads
  float start_time = 0, end_time = 1;
  unsigned mask = 0xFFFFFFFFu;
  RTCFilterFunctionN intersect_filter = nullptr;
  RTCFilterFunctionN occluded_filter = nullptr;
  void* user_ptr = nullptr;
  bool takes_query_filters = false;  ///< also those that are not for all meshes: Embree 4

  std::size_t vertex_count() const { return steps[0].size() - 1; }
};

/// `triangles` separate triangles around [-1, 1]^3 whose corners wander from step to step.
TestMesh triangle_soup(std::uint32_t seed, unsigned triangles, unsigned step_count);

/// Where no ray of random_ray gets, and so large that the kernels trace what they get together in flight.
TestMesh large_mesh_far_away();

/// A single triangle that fills x, y in [-1, 1] at height z, without motion in `step_count` steps.
TestMesh flat_triangle(float z, unsigned step_count = 1);

/// The plugin's arguments for a mesh; `pointers` must outlive the call that takes them.
StbvhMeshArguments arguments_of(const TestMesh& mesh, std::vector<const void*>& pointers);

/// Releases on scope exit.
struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
  void operator()(StbvhGeometry geometry) const { stbvhReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<RTCDeviceTy, Release>;
using Scene = std::unique_ptr<RTCSceneTy, Release>;
using NativeGeometry = std::unique_ptr<RTCGeometryTy, Release>;
using OwnGeometry = std::unique_ptr<StbvhGeometryTy, Release>;

Device new_device();
Scene new_scene(const Device& device);

/// Embree's triangle geometry, committed.
NativeGeometry native_geometry(const Device& device, const TestMesh& mesh);
NativeGeometry native_geometry(const Device& device, TestMesh&& mesh) = delete;  // shares its buffers

/// All meshes in one geometry of the plugin, committed; geomID of each: its index.
OwnGeometry own_geometry(const Device& device, const std::vector<TestMesh>& meshes);
OwnGeometry own_geometry(const Device& device, std::vector<TestMesh>&& meshes) = delete;

/// Two committed scenes with the same contents.
struct ScenePair {
  std::vector<TestMesh> meshes;
  Scene native;
  Scene own;
  OwnGeometry geometry;
};
ScenePair scene_pair(const Device& device, std::vector<TestMesh> meshes);

/// A ray from outside into the soup; times include 0, 1 and multiples of 1/8 exactly.
RTCRayHit random_ray(Random& random);

RTCRayHit ray_down(float x, float y, float time);

RTCRayHit intersect(RTCScene scene, RTCRayHit ray, const QueryOptions& options = {});
/// Whether the ray is occluded: tfar must be -inf then, and unchanged otherwise.
bool is_occluded(RTCScene scene, const RTCRayHit& ray, const QueryOptions& options = {});

/// The same by stbvhIntersect1 and stbvhOccluded1.
RTCRayHit intersect_directly(StbvhGeometry geometry, RTCRayHit ray, const QueryOptions& options = {});
bool is_occluded_directly(StbvhGeometry geometry, const RTCRayHit& ray, const QueryOptions& options = {});

bool same_bits(const RTCRayHit& a, const RTCRayHit& b);

/// Same IDs; distance, u, v and normal within rounding.
void expect_same_hit(const RTCRayHit& native, const RTCRayHit& own);

/// Traces `count` random rays through both, closest and any hit; some must hit, some must not.
void expect_same_hits(RTCScene native, RTCScene own, unsigned count, std::uint32_t seed);

}  // namespace stbvh::test
