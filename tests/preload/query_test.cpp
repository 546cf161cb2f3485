/// What a user geometry cannot answer: point queries, interpolation.
#include <cmath>
#include <limits>

#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

struct Found {
  unsigned geom_id = RTC_INVALID_GEOMETRY_ID, prim_id = RTC_INVALID_GEOMETRY_ID,
           inst_id = RTC_INVALID_GEOMETRY_ID;
  unsigned calls_of_geometry = 0;
};

struct Search {
  const std::vector<Mesh>* meshes;
  Found found;
};

/// Nearest first corner of a triangle: what is asked does not matter, as long as the answer is unique.
bool nearest_corner(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  const Mesh& mesh = (*search.meshes)[arguments->geomID];
  Position p = mesh.steps[0][mesh.indices[3 * arguments->primID]];
  const RTCPointQueryContext& context = *arguments->context;
  if (context.instStackSize > 0) {
    const float* const m = context.inst2world[0];
    p = {m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
         m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]};
  }
  const RTCPointQuery& query = *arguments->query;
  const float distance = std::hypot(p.x - query.x, p.y - query.y, p.z - query.z);
  if (distance >= query.radius) return false;
  arguments->query->radius = distance;
  search.found.geom_id = arguments->geomID;
  search.found.prim_id = arguments->primID;
  search.found.inst_id = context.instStackSize > 0 ? context.instID[0] : RTC_INVALID_GEOMETRY_ID;
  return true;
}

Found ask(const Embree& embree, RTCScene scene, const std::vector<Mesh>& meshes, const Position& p) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query{p.x, p.y, p.z, 0.0f, 0.5f};
  Search search{&meshes, {}};
  embree.rtcPointQuery(scene, &query, &context, nearest_corner, &search);
  return search.found;
}

void expect_same_answers(const Twice& twice, const std::vector<Mesh>& meshes) {
  Random random(2);
  unsigned found = 0;
  for (int i = 0; i < 300; ++i) {
    const Position p{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    const Found own = ask(ours(), twice.our_scene, meshes, p);
    const Found reference = ask(native(), twice.native_scene, meshes, p);
    ASSERT_EQ(own.geom_id, reference.geom_id);
    ASSERT_EQ(own.prim_id, reference.prim_id);
    ASSERT_EQ(own.inst_id, reference.inst_id);
    found += own.geom_id != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
  }
  EXPECT_GT(found, 100u);
}

TEST(PreloadPointQuery, IsAnsweredAsBeforeAndAfterChanges) {
  std::vector<Mesh> meshes{triangle_soup(1, 150, 3), triangle_soup(2, 100, 1), triangle_soup(3, 100, 5)};
  Twice twice;
  for (const Mesh& mesh : meshes) twice.add(mesh);
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  expect_same_answers(twice, meshes);
  for (auto& step : meshes[0].steps) {
    for (Position& p : step) p.x = -p.x;
  }
  twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
    const RTCGeometry geometry = embree.rtcGetGeometry(scene, 0);
    for (unsigned step = 0; step < 3; ++step) {
      embree.rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step);
    }
    embree.rtcCommitGeometry(geometry);
    embree.rtcDisableGeometry(embree.rtcGetGeometry(scene, 2));
  });
  twice.commit();
  expect_same_answers(twice, meshes);
}

TEST(PreloadPointQuery, GoesThroughInstances) {
  const std::vector<Mesh> meshes{triangle_soup(4, 200, 3), triangle_soup(5, 100, 2)};
  Twice twice;
  RTCScene inner[2];
  int side = 0;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    inner[side] = embree.rtcNewScene(device);
    for (const Mesh& mesh : meshes) attach(embree, inner[side], new_mesh(embree, device, mesh));
    embree.rtcCommitScene(inner[side]);
    for (int i = 0; i < 2; ++i) {
      const RTCGeometry instance = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
      embree.rtcSetGeometryInstancedScene(instance, inner[side]);
      const float matrix[12] = {0,     1,      0, -1, 0, 0, 0, 1, 0.3f * static_cast<float>(i) - 0.2f,
                                0.25f, 0.125f, 0};
      embree.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
      attach(embree, scene, instance);
    }
    ++side;
  });
  twice.commit();
  expect_same_answers(twice, meshes);
  side = 0;
  twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {  // one inner mesh less
    embree.rtcDetachGeometry(inner[side], 1);
    embree.rtcCommitScene(inner[side]);
    for (unsigned i = 0; i < 2; ++i) embree.rtcCommitGeometry(embree.rtcGetGeometry(scene, i));
    embree.rtcReleaseScene(inner[side++]);
  });
  twice.commit();
  expect_same_answers(twice, meshes);
}

bool count_call(RTCPointQueryFunctionArguments* arguments) {
  ++static_cast<Search*>(arguments->userPtr)->found.calls_of_geometry;
  return false;
}

TEST(PreloadPointQuery, CallsTheGeometrysFunction) {
  const std::vector<Mesh> meshes{triangle_soup(6, 50, 3)};
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCGeometry geometry = new_mesh(embree, device, meshes[0]);
    embree.rtcSetGeometryPointQueryFunction(geometry, count_call);
    attach(embree, scene, geometry);
  });
  twice.commit();
  const Found own = ask(ours(), twice.our_scene, meshes, {0, 0, 0});
  const Found reference = ask(native(), twice.native_scene, meshes, {0, 0, 0});
  EXPECT_GT(own.calls_of_geometry, 0u);
  EXPECT_EQ(own.calls_of_geometry, reference.calls_of_geometry);
}

TEST(PreloadInterpolate, OfATakenOverMesh) {
  const Mesh mesh = triangle_soup(7, 20, 3);
  Twice twice;
  twice.add(mesh);
  twice.commit();
  for (unsigned step = 0; step < 3; ++step) {
    float p[2][3];
    int side = 0;
    twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
      RTCInterpolateArguments arguments{};
      arguments.geometry = embree.rtcGetGeometry(scene, 0);
      arguments.primID = 7;
      arguments.u = 0.25f;
      arguments.v = 0.5f;
      arguments.bufferType = RTC_BUFFER_TYPE_VERTEX;
      arguments.bufferSlot = step;
      arguments.P = p[side++];
      arguments.valueCount = 3;
      embree.rtcInterpolate(&arguments);
    });
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(p[0][axis], p[1][axis]);
    EXPECT_NEAR(
        p[0][0],
        0.25f * mesh.steps[step][21].x + 0.25f * mesh.steps[step][22].x + 0.5f * mesh.steps[step][23].x,
        1e-5f);
  }
}

}  // namespace
}  // namespace stbvh::preload_test
