// Point queries are not answered: docs/api.md says what an application sees.
#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

struct Calls {
  unsigned of_plugin = 0;
  unsigned of_triangles = 0;
};

bool count_calls(RTCPointQueryFunctionArguments* args) {
  auto& calls = *static_cast<Calls*>(args->userPtr);
  EXPECT_EQ(args->primID, 0u);
  ++(args->geomID == 7 ? calls.of_plugin : calls.of_triangles);
  return false;
}

TEST(PluginPointQueries, CallTheApplicationOnceForTheWholeGeometry) {
  const Device device = new_device();
  const std::vector<TestMesh> meshes{triangle_soup(1, 50, 3)};
  const TestMesh triangle = flat_triangle(0);
  const OwnGeometry geometry = own_geometry(device, meshes);
  const Scene scene = new_scene(device);
  rtcAttachGeometryByID(scene.get(), stbvhGetGeometry(geometry.get()), 7);
  rtcAttachGeometryByID(scene.get(), native_geometry(device, triangle).get(), 0);
  rtcCommitScene(scene.get());
  Calls calls;
  RTCPointQuery query{0, 0, 0, .5f, 1};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene.get(), &query, &context, count_calls, &calls);
  EXPECT_EQ(calls.of_plugin, 1u);
  EXPECT_EQ(calls.of_triangles, 1u);
  rtcPointQuery(scene.get(), &query, &context, nullptr, nullptr);
}

}  // namespace
}  // namespace stbvh::test
