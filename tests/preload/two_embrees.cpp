#include "tests/preload/two_embrees.h"

#include <dlfcn.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "plugin/preload/tracked_scene.h"

namespace stbvh::preload_test {
namespace {

bool close(float a, float b, float magnitude) {
  return std::fabs(a - b) <= 2e-4f * std::max(1.0f, magnitude);
}

}  // namespace

const Embree& ours() {
  static const Embree kOurs = [] {
    Embree embree;
#define STBVH_FUNCTION(name) embree.name = &::name;
#include "tests/preload/embree_functions.inl"
#undef STBVH_FUNCTION
    return embree;
  }();
  return kOurs;
}

const Embree& native() {
  static const Embree kNative = [] {
    Embree embree;
#define STBVH_FUNCTION(name)                                                  \
  embree.name = reinterpret_cast<decltype(&::name)>(dlsym(RTLD_NEXT, #name)); \
  if (embree.name == nullptr) std::abort();
#include "tests/preload/embree_functions.inl"
#undef STBVH_FUNCTION
    return embree;
  }();
  return kNative;
}

Mesh triangle_soup(std::uint32_t seed, unsigned triangles, unsigned step_count) {
  Random random(seed);
  Mesh mesh;
  mesh.steps.resize(step_count);
  for (unsigned triangle = 0; triangle < triangles; ++triangle) {
    const Position center{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    for (unsigned corner = 0; corner < 3; ++corner) {
      mesh.indices.push_back(static_cast<std::uint32_t>(mesh.indices.size()));
      Position p{center.x + random.between(-0.2f, 0.2f), center.y + random.between(-0.2f, 0.2f),
                 center.z + random.between(-0.2f, 0.2f)};
      for (auto& step : mesh.steps) {
        step.push_back(p);
        p = {p.x + random.between(-0.1f, 0.1f), p.y + random.between(-0.1f, 0.1f),
             p.z + random.between(-0.1f, 0.1f)};
      }
    }
  }
  for (auto& step : mesh.steps) step.push_back({});
  return mesh;
}

Mesh flat_triangle(float z, unsigned step_count) {
  Mesh mesh;
  mesh.indices = {0, 1, 2};
  mesh.steps.assign(step_count, {{-1, -1, z}, {3, -1, z}, {-1, 3, z}, {}});
  return mesh;
}

RTCGeometry new_mesh(const Embree& embree, RTCDevice device, const Mesh& mesh) {
  const RTCGeometry geometry = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  embree.rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(mesh.steps.size()));
  if (mesh.steps.size() > 1) embree.rtcSetGeometryTimeRange(geometry, mesh.start_time, mesh.end_time);
  embree.rtcSetGeometryMask(geometry, mesh.mask);
  embree.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(),
                                    0, 12, mesh.triangle_count());
  for (unsigned step = 0; step < mesh.steps.size(); ++step) {
    embree.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3,
                                      mesh.steps[step].data(), 0, 12, mesh.vertex_count());
  }
  return geometry;
}

unsigned attach(const Embree& embree, RTCScene scene, RTCGeometry geometry) {
  embree.rtcCommitGeometry(geometry);
  const unsigned geom_id = embree.rtcAttachGeometry(scene, geometry);
  embree.rtcReleaseGeometry(geometry);
  return geom_id;
}

bool is_taken_over(RTCScene scene) {
  return preload::scenes().find(scene)->has_group();
}

bool answers_alone(RTCScene scene) {
  return preload::scenes().find(scene)->answers_alone() != nullptr;
}

void expect_same_bits(const RTCRayHit& a, const RTCRayHit& b) {
  EXPECT_EQ(std::memcmp(&a, &b, sizeof(float) * kMembers), 0);
}

Twice::Twice()
    : our_device(ours().rtcNewDevice(nullptr)),
      native_device(native().rtcNewDevice(nullptr)),
      our_scene(ours().rtcNewScene(our_device)),
      native_scene(native().rtcNewScene(native_device)) {}

Twice::~Twice() {
  EXPECT_EQ(ours().rtcGetDeviceError(our_device), RTC_ERROR_NONE);
  EXPECT_EQ(native().rtcGetDeviceError(native_device), RTC_ERROR_NONE);
  ours().rtcReleaseScene(our_scene);
  native().rtcReleaseScene(native_scene);
  ours().rtcReleaseDevice(our_device);
  native().rtcReleaseDevice(native_device);
}

void Twice::both(const std::function<void(const Embree&, RTCDevice, RTCScene)>& action) {
  action(ours(), our_device, our_scene);
  action(native(), native_device, native_scene);
}

void Twice::add(const Mesh& mesh) {
  both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    attach(embree, scene, new_mesh(embree, device, mesh));
  });
}

void Twice::commit() {
  ours().rtcCommitScene(our_scene);
  native().rtcCommitScene(native_scene);
}

std::vector<RTCRayHit> random_rays(std::uint32_t seed, unsigned count) {
  Random random(seed);
  std::vector<RTCRayHit> rays(count);
  for (RTCRayHit& r : rays) {
    RTCRay& ray = r.ray;
    ray.org_x = random.between(-3, 3);
    ray.org_y = random.between(-3, 3);
    ray.org_z = random.unit() < 0.5f ? -3.0f : 3.0f;
    ray.dir_x = random.between(-1, 1) - ray.org_x;
    ray.dir_y = random.between(-1, 1) - ray.org_y;
    ray.dir_z = random.between(-1, 1) - ray.org_z;
    ray.tnear = 0;
    ray.tfar = random.unit() < 0.8f ? std::numeric_limits<float>::infinity() : random.between(0.3f, 1.5f);
    ray.time = random.unit();
    ray.mask = 0xFFFFFFFFu;
    ray.id = 0;
    ray.flags = 0xDEADBEEFu;  // as applications leave it
    r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  }
  return rays;
}

void expect_same_hit(const RTCRayHit& own, const RTCRayHit& reference) {
  ASSERT_EQ(own.hit.geomID, reference.hit.geomID);
  if (reference.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  ASSERT_EQ(own.hit.primID, reference.hit.primID);
  ASSERT_EQ(own.hit.instID[0], reference.hit.instID[0]);
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  ASSERT_EQ(own.hit.instPrimID[0], reference.hit.instPrimID[0]);
#endif
  EXPECT_TRUE(close(own.ray.tfar, reference.ray.tfar, reference.ray.tfar));
  const float size =
      std::fabs(reference.hit.Ng_x) + std::fabs(reference.hit.Ng_y) + std::fabs(reference.hit.Ng_z);
  EXPECT_TRUE(close(own.hit.Ng_x, reference.hit.Ng_x, size));
  EXPECT_TRUE(close(own.hit.Ng_y, reference.hit.Ng_y, size));
  EXPECT_TRUE(close(own.hit.Ng_z, reference.hit.Ng_z, size));
  EXPECT_NEAR(own.hit.u, reference.hit.u, 2e-3f);
  EXPECT_NEAR(own.hit.v, reference.hit.v, 2e-3f);
}

void expect_same_hits(RTCScene our_scene, RTCScene native_scene, const std::vector<RTCRayHit>& rays) {
  std::size_t hit_count = 0;
  for (const RTCRayHit& ray : rays) {
    RTCRayHit own = ray, reference = ray;
    intersect_one(our_scene, own);
    intersect_one(native_scene, reference);
    expect_same_hit(own, reference);
    if (::testing::Test::HasFatalFailure()) return;
    hit_count += reference.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
    RTCRay own_shadow = ray.ray, reference_shadow = ray.ray;
    occluded_one(our_scene, own_shadow);
    occluded_one(native_scene, reference_shadow);
    ASSERT_EQ(own_shadow.tfar, reference_shadow.tfar);
  }
  EXPECT_GE(hit_count * 10, rays.size());
}

RTCRayHit ray_along_z(float x, float y, float time) {
  RTCRayHit r{};
  r.ray.org_x = x;
  r.ray.org_y = y;
  r.ray.org_z = -100;
  r.ray.dir_z = 1;
  r.ray.tfar = std::numeric_limits<float>::infinity();
  r.ray.time = time;
  r.ray.mask = 0xFFFFFFFFu;
  r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

bool hits(RTCScene scene, float x, float y, float time, unsigned mask) {
  RTCRayHit r = ray_along_z(x, y, time);
  r.ray.mask = mask;
  occluded_one(scene, r.ray);
  return r.ray.tfar < 0;
}

unsigned geom_id_hit(RTCScene scene, float x, float y, float time) {
  RTCRayHit r = ray_along_z(x, y, time);
  intersect_one(scene, r);
  return r.hit.geomID;
}

}  // namespace stbvh::preload_test
