// What Embree is told about bounds.
#include <algorithm>
#include <cmath>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

void expect_equal(const RTCBounds& a, const RTCBounds& b) {
  EXPECT_EQ(a.lower_x, b.lower_x);
  EXPECT_EQ(a.lower_y, b.lower_y);
  EXPECT_EQ(a.lower_z, b.lower_z);
  EXPECT_EQ(a.upper_x, b.upper_x);
  EXPECT_EQ(a.upper_y, b.upper_y);
  EXPECT_EQ(a.upper_z, b.upper_z);
}

/// Whether `a` contains `b` and is at most `slack` larger.
void expect_contains(const RTCBounds& a, const RTCBounds& b, float slack) {
  const float lower[3][2] = {{a.lower_x, b.lower_x}, {a.lower_y, b.lower_y}, {a.lower_z, b.lower_z}};
  const float upper[3][2] = {{a.upper_x, b.upper_x}, {a.upper_y, b.upper_y}, {a.upper_z, b.upper_z}};
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(lower[axis][0], lower[axis][1]);
    EXPECT_GE(lower[axis][0], lower[axis][1] - slack);
    EXPECT_GE(upper[axis][0], upper[axis][1]);
    EXPECT_LE(upper[axis][0], upper[axis][1] + slack);
  }
}

/// A soup whose outermost vertices belong to triangles that are left out, or to none.
TestMesh soup_with_invalid_triangles(unsigned steps) {
  TestMesh mesh = triangle_soup(steps, 300, steps);
  mesh.steps.back()[0] = {50, 50, 50};
  mesh.steps.front()[1].y = std::numeric_limits<float>::quiet_NaN();
  mesh.steps.front()[6] = {-50, 0, 0};
  mesh.indices[6] = 5000;
  return mesh;
}

RTCBounds to_bounds(const Box3f& box) {
  return {box.lower.x, box.lower.y, box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, 0};
}

TEST(PluginBounds, OfASceneOfOneMeshAreEmbrees) {
  // With more steps Embree merges lines fitted to each triangle, of a user geometry it sees the boxes.
  const Device device = new_device();
  for (const unsigned steps : {1u, 2u}) {
    const ScenePair pair = scene_pair(device, {soup_with_invalid_triangles(steps)});
    RTCBounds native, own;
    rtcGetSceneBounds(pair.native.get(), &native);
    rtcGetSceneBounds(pair.own.get(), &own);
    expect_equal(native, own);
    RTCLinearBounds native_linear, own_linear;
    rtcGetSceneLinearBounds(pair.native.get(), &native_linear);
    rtcGetSceneLinearBounds(pair.own.get(), &own_linear);
    expect_equal(native_linear.bounds0, own_linear.bounds0);
    expect_equal(native_linear.bounds1, own_linear.bounds1);
  }
}

TEST(PluginBounds, OfSeveralStaticMeshesAreExact) {
  const Device device = new_device();
  const ScenePair pair = scene_pair(device, {triangle_soup(1, 50, 1), triangle_soup(2, 50, 1)});
  RTCBounds native, own;
  rtcGetSceneBounds(pair.native.get(), &native);
  rtcGetSceneBounds(pair.own.get(), &own);
  expect_equal(native, own);
}

TEST(PluginBounds, OfSeveralMeshesContainThemAndAreTight) {
  const Device device = new_device();
  const ScenePair pair =
      scene_pair(device, {triangle_soup(1, 50, 5), triangle_soup(2, 50, 1), triangle_soup(3, 50, 7)});
  RTCBounds own;
  rtcGetSceneBounds(pair.own.get(), &own);
  Box3f exact = Box3f::empty();
  for (const TestMesh& mesh : pair.meshes) {
    for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
      for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
        const Position& p = mesh.steps[step][i];
        exact.extend(Vec3f{p.x, p.y, p.z});
      }
    }
  }
  expect_contains(own, to_bounds(exact), .1f);
}

/// A scene that Embree must ask its own tree about: a lone user geometry is called without a box test.
Scene scene_with_neighbours(const Device& device, RTCGeometry geometry) {
  Scene scene = new_scene(device);
  rtcAttachGeometryByID(scene.get(), geometry, 0);
  static const std::vector<TestMesh> kNeighbours{flat_triangle(-40, 3), flat_triangle(-41, 3),
                                                 flat_triangle(-42, 3), flat_triangle(-50),
                                                 flat_triangle(-51)};
  for (const TestMesh& mesh : kNeighbours)
    rtcAttachGeometry(scene.get(), native_geometry(device, mesh).get());
  rtcCommitScene(scene.get());
  return scene;
}

/// Rays at points of random triangles where they are at the ray's time, from afar and along the bounds.
RTCRayHit ray_at_mesh(Random& random, const TestMesh& mesh) {
  const std::size_t segments = mesh.steps.size() - 1;
  const float time = random.unit();
  const float u = (time - mesh.start_time) / (mesh.end_time - mesh.start_time) * static_cast<float>(segments);
  const float clamped = std::clamp(u, 0.0f, static_cast<float>(segments));
  const std::size_t step = std::min(static_cast<std::size_t>(clamped), segments == 0 ? 0 : segments - 1);
  const float f = clamped - static_cast<float>(step);
  const auto& first = mesh.steps[step];
  const auto& second = mesh.steps[segments == 0 ? 0 : step + 1];
  const std::size_t triangle = random.below(static_cast<unsigned>(mesh.indices.size() / 3));
  float weights[3] = {random.unit(), random.unit(), random.unit()};
  if (random.below(2) == 0) weights[0] = 1, weights[1] = weights[2] = 1e-3f;
  const float sum = weights[0] + weights[1] + weights[2];
  Position p{0, 0, 0};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t i = mesh.indices[3 * triangle + corner];
    const float w = weights[corner] / sum;
    p.x += w * ((1 - f) * first[i].x + f * second[i].x);
    p.y += w * ((1 - f) * first[i].y + f * second[i].y);
    p.z += w * ((1 - f) * first[i].z + f * second[i].z);
  }
  RTCRayHit query = random_ray(random);
  query.ray.time = time;
  query.ray.tnear = 0;
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.dir_x = p.x - query.ray.org_x;
  query.ray.dir_y = p.y - query.ray.org_y;
  query.ray.dir_z = p.z - query.ray.org_z;
  return query;
}

TEST(PluginBounds, NothingIsLostInEmbreesTreeAbove) {
  const Device device = new_device();
  for (unsigned round = 0; round < 12; ++round) {
    std::vector<TestMesh> meshes;
    Random random(round);
    for (unsigned i = 0; i <= round % 4; ++i) {
      meshes.push_back(triangle_soup(round * 10 + i, 4, 1 + random.below(20)));
      if (i > 1) meshes.back().start_time = .3f, meshes.back().end_time = .65f;
    }
    const OwnGeometry geometry = own_geometry(device, meshes);
    const Scene alone = new_scene(device);
    rtcAttachGeometryByID(alone.get(), stbvhGetGeometry(geometry.get()), 0);
    rtcCommitScene(alone.get());
    const Scene crowded = scene_with_neighbours(device, stbvhGetGeometry(geometry.get()));
    for (unsigned i = 0; i < 3000; ++i) {
      const RTCRayHit ray = ray_at_mesh(random, meshes[random.below(static_cast<unsigned>(meshes.size()))]);
      const RTCRayHit expected = intersect(alone.get(), ray), found = intersect(crowded.get(), ray);
      if (expected.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      ASSERT_EQ(expected.hit.geomID, found.hit.geomID) << "round " << round << " ray " << i;
      ASSERT_EQ(expected.hit.primID, found.hit.primID);
      ASSERT_EQ(expected.ray.tfar, found.ray.tfar);
    }
  }
}

}  // namespace
}  // namespace stbvh::test
