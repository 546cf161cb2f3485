/// What is attached, bound and enabled: buffers of all kinds, IDs, errors, edits between commits.
#include <cstring>

#include "tests/preload/two_embrees.h"

namespace stbvh::preload_test {
namespace {

/// Between the application's IDs at the first commit and that of our user geometry.
constexpr unsigned kSpareIds = 64;

constexpr RTCBufferType kIndex = RTC_BUFFER_TYPE_INDEX;
constexpr RTCBufferType kVertex = RTC_BUFFER_TYPE_VERTEX;

TEST(PreloadBuffers, ContentsAreReadAtCommitWhateverTheStride) {
  const Mesh mesh = triangle_soup(1, 200, 4);
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCGeometry geometry = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    embree.rtcSetGeometryTimeStepCount(geometry, 4);
    char* const indices = static_cast<char*>(
        embree.rtcSetNewGeometryBuffer(geometry, kIndex, 0, RTC_FORMAT_UINT3, 20, mesh.triangle_count()));
    EXPECT_EQ(embree.rtcGetGeometryBufferData(geometry, kIndex, 0), indices);
    for (unsigned step = 0; step < 4; ++step) {
      const std::size_t stride = 28;
      char* const vertices = static_cast<char*>(embree.rtcSetNewGeometryBuffer(
          geometry, kVertex, step, RTC_FORMAT_FLOAT3, stride, mesh.vertex_count()));
      for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
        std::memcpy(vertices + i * stride, &mesh.steps[step][i], 12);
      }
    }
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
      std::memcpy(indices + i * 20, &mesh.indices[3 * i], 12);
    }
    attach(embree, scene, geometry);
  });
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(3, 2000));
}

TEST(PreloadBuffers, OfTheirOwnWithOffsets) {
  const Mesh mesh = triangle_soup(2, 100, 2);
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCGeometry geometry = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    embree.rtcSetGeometryTimeStepCount(geometry, 2);
    const std::size_t step_bytes = 16 * mesh.vertex_count();
    const RTCBuffer buffer = embree.rtcNewBuffer(device, 32 + 2 * step_bytes);
    for (unsigned step = 0; step < 2; ++step) {
      embree.rtcSetGeometryBuffer(geometry, kVertex, step, RTC_FORMAT_FLOAT3, buffer, 32 + step * step_bytes,
                                  16, mesh.vertex_count());
      for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
        std::memcpy(static_cast<char*>(embree.rtcGetBufferData(buffer)) + 32 + step * step_bytes + 16 * i,
                    &mesh.steps[step][i], 12);
      }
    }
    embree.rtcReleaseBuffer(buffer);  // the geometry keeps it
    embree.rtcSetSharedGeometryBuffer(geometry, kIndex, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 12, 12,
                                      mesh.triangle_count() - 1);
    attach(embree, scene, geometry);
  });
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  expect_same_hits(twice.our_scene, twice.native_scene, random_rays(3, 2000));
}

TEST(PreloadBuffers, RefusedOnesChangeNothing) {
  const Mesh mesh = flat_triangle(0, 2);
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    const RTCGeometry geometry = new_mesh(embree, device, mesh);
    const auto set = [&](RTCBufferType type, unsigned slot, RTCFormat format, std::size_t stride) {
      embree.rtcSetSharedGeometryBuffer(geometry, type, slot, format, mesh.steps[0].data(), 0, stride, 1);
      return embree.rtcGetDeviceError(device);
    };
    EXPECT_NE(set(kVertex, 5, RTC_FORMAT_FLOAT3, 12), RTC_ERROR_NONE);
    EXPECT_NE(set(kVertex, 0, RTC_FORMAT_FLOAT4, 16), RTC_ERROR_NONE);
    EXPECT_NE(set(kVertex, 0, RTC_FORMAT_FLOAT3, 13), RTC_ERROR_NONE);
    EXPECT_NE(set(kIndex, 0, RTC_FORMAT_UINT2, 8), RTC_ERROR_NONE);
    attach(embree, scene, geometry);
  });
  twice.commit();
  EXPECT_TRUE(is_taken_over(twice.our_scene));
  EXPECT_TRUE(hits(twice.our_scene, 0, 0, 0.5f));
  EXPECT_TRUE(hits(twice.native_scene, 0, 0, 0.5f));
}

TEST(PreloadBuffers, ChangesCountFromTheNextCommitOn) {
  Mesh mesh = flat_triangle(0, 3);
  Twice twice;
  RTCGeometry geometries[2];
  int i = 0;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    geometries[i] = new_mesh(embree, device, mesh);
    attach(embree, scene, geometries[i++]);
  });
  twice.commit();
  for (int round = 0; round < 5; ++round) {
    const float x = static_cast<float>(10 * round);
    for (auto& step : mesh.steps) step = {{x - 1, -1, 0}, {x + 3, -1, 0}, {x - 1, 3, 0}, {}};
    i = 0;
    twice.both([&](const Embree& embree, RTCDevice, RTCScene) {
      for (unsigned step = 0; step < 3; ++step) embree.rtcUpdateGeometryBuffer(geometries[i], kVertex, step);
      embree.rtcCommitGeometry(geometries[i++]);
    });
    twice.commit();
    for (const RTCScene scene : {twice.our_scene, twice.native_scene}) {
      EXPECT_TRUE(hits(scene, x, 0, 0.5f));
      EXPECT_FALSE(hits(scene, x - 10, 0, 0.5f));
    }
  }
}

TEST(PreloadContents, AnInstancesSceneNoticesInnerChanges) {
  Mesh mesh = flat_triangle(0, 3);
  Twice twice;
  RTCScene inner[2];
  RTCGeometry geometry[2], instance[2];
  int i = 0;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    inner[i] = embree.rtcNewScene(device);
    geometry[i] = new_mesh(embree, device, mesh);
    attach(embree, inner[i], geometry[i]);
    embree.rtcCommitScene(inner[i]);
    instance[i] = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    embree.rtcSetGeometryInstancedScene(instance[i], inner[i]);
    attach(embree, scene, instance[i]);
    embree.rtcReleaseScene(inner[i++]);
  });
  twice.commit();
  for (auto& step : mesh.steps) step = {{49, -1, 0}, {53, -1, 0}, {49, 3, 0}, {}};
  i = 0;
  twice.both([&](const Embree& embree, RTCDevice, RTCScene) {
    for (unsigned step = 0; step < 3; ++step) embree.rtcUpdateGeometryBuffer(geometry[i], kVertex, step);
    embree.rtcCommitGeometry(geometry[i]);
    embree.rtcCommitScene(inner[i]);
    embree.rtcCommitGeometry(instance[i++]);
  });
  twice.commit();
  for (const RTCScene scene : {twice.our_scene, twice.native_scene}) {
    EXPECT_TRUE(hits(scene, 50, 0, 0.5f));
    EXPECT_FALSE(hits(scene, 0, 0, 0.5f));
  }
}

TEST(PreloadContents, HandlesAndIdsAreTheApplications) {
  const Mesh mesh = flat_triangle(0, 2);
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    std::vector<RTCGeometry> handles;
    for (unsigned i = 0; i < 3; ++i) {
      handles.push_back(new_mesh(embree, device, mesh));
      embree.rtcSetGeometryUserData(handles[i], reinterpret_cast<void*>(std::uintptr_t{i}));
      EXPECT_EQ(attach(embree, scene, handles[i]), i);
    }
    embree.rtcCommitScene(scene);
    for (unsigned i = 0; i < 3; ++i) {
      EXPECT_EQ(embree.rtcGetGeometry(scene, i), handles[i]);
      EXPECT_EQ(embree.rtcGetGeometryThreadSafe(scene, i), handles[i]);
      EXPECT_EQ(embree.rtcGetGeometryUserData(handles[i]), reinterpret_cast<void*>(std::uintptr_t{i}));
    }
    // After a commit too, IDs come as from Embree: the next, a chosen one, one that is free again.
    EXPECT_EQ(attach(embree, scene, new_mesh(embree, device, mesh)), 3u);
    embree.rtcCommitScene(scene);
    const unsigned chosen_id = 3 + kSpareIds;
    if (scene == twice.our_scene) {
      ASSERT_NE(native().rtcGetGeometry(scene, chosen_id), nullptr);
    }
    const RTCGeometry chosen = new_mesh(embree, device, mesh);
    embree.rtcCommitGeometry(chosen);
    embree.rtcAttachGeometryByID(scene, chosen, chosen_id);  // where the proxy is
    embree.rtcReleaseGeometry(chosen);
    embree.rtcCommitScene(scene);
    EXPECT_EQ(embree.rtcGetGeometry(scene, chosen_id), chosen);
    EXPECT_TRUE(hits(scene, 0, 0, 0.5f));
    embree.rtcDetachGeometry(scene, 1);
    embree.rtcCommitScene(scene);
    EXPECT_EQ(attach(embree, scene, new_mesh(embree, device, mesh)), 1u);
    for (unsigned i = 0; i < 200; ++i) {  // past every proxy
      const unsigned expected = 4 + i < chosen_id ? 4 + i : 5 + i;
      EXPECT_EQ(attach(embree, scene, new_mesh(embree, device, mesh)), expected);
      if (i % 70 == 0) embree.rtcCommitScene(scene);
    }
    embree.rtcCommitScene(scene);
    EXPECT_EQ(embree.rtcGetDeviceError(device), RTC_ERROR_NONE);
  });
}

TEST(PreloadContents, MistakesGiveEmbreesErrorsAndChangeNothing) {
  const Mesh mesh = flat_triangle(0, 2);
  Twice twice;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    attach(embree, scene, new_mesh(embree, device, mesh));
    embree.rtcCommitScene(scene);
    const RTCGeometry other = new_mesh(embree, device, mesh);
    embree.rtcCommitGeometry(other);
    embree.rtcAttachGeometryByID(scene, other, 0);
    EXPECT_EQ(embree.rtcGetDeviceError(device), RTC_ERROR_INVALID_OPERATION);
    embree.rtcReleaseGeometry(other);
    for (const unsigned geom_id : {1u, 7u, 1 + kSpareIds}) {
      embree.rtcDetachGeometry(scene, geom_id);
      EXPECT_EQ(embree.rtcGetDeviceError(device), RTC_ERROR_INVALID_OPERATION);
    }
    embree.rtcSetGeometryTimeStepCount(embree.rtcGetGeometry(scene, 0), 130);
    EXPECT_NE(embree.rtcGetDeviceError(device), RTC_ERROR_NONE);
    EXPECT_TRUE(hits(scene, 0, 0, 0.5f));
    embree.rtcSetGeometryMask(embree.rtcGetGeometry(scene, 0), 3);
    embree.rtcCommitScene(scene);
    EXPECT_EQ(embree.rtcGetDeviceError(device), RTC_ERROR_INVALID_OPERATION);  // not committed
    embree.rtcCommitGeometry(embree.rtcGetGeometry(scene, 0));
    embree.rtcCommitScene(scene);
    EXPECT_EQ(embree.rtcGetDeviceError(device), RTC_ERROR_NONE);
    EXPECT_TRUE(hits(scene, 0, 0, 0.5f, 2));
    EXPECT_FALSE(hits(scene, 0, 0, 0.5f, 4));
  });
}

TEST(PreloadContents, RandomEditsLeaveWhatEmbreeWouldShow) {
  std::vector<Mesh> meshes;
  for (unsigned i = 0; i < 6; ++i) meshes.push_back(triangle_soup(i, 40, 1 + i));
  Random random(99);
  Twice twice;
  std::vector<RTCGeometry> geometries[2];
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene) {
    for (const Mesh& mesh : meshes) {
      geometries[&embree == &ours() ? 0 : 1].push_back(new_mesh(embree, device, mesh));
      embree.rtcCommitGeometry(geometries[&embree == &ours() ? 0 : 1].back());
    }
  });
  std::vector<unsigned> attached(6, RTC_INVALID_GEOMETRY_ID);
  for (int round = 0; round < 150; ++round) {
    const unsigned which = random.below(6), action = random.below(4);
    unsigned geom_ids[2]{};
    int side = 0;
    twice.both([&](const Embree& embree, RTCDevice, RTCScene scene) {
      const RTCGeometry geometry = geometries[side][which];
      if (action == 0) embree.rtcDisableGeometry(geometry);
      if (action == 1) embree.rtcEnableGeometry(geometry);
      if (action == 3) embree.rtcCommitGeometry(geometry);
      if (action == 2) {
        if (attached[which] != RTC_INVALID_GEOMETRY_ID) {
          embree.rtcDetachGeometry(scene, attached[which]);
          geom_ids[side] = RTC_INVALID_GEOMETRY_ID;
        } else {
          geom_ids[side] = embree.rtcAttachGeometry(scene, geometry);
        }
      }
      ++side;
    });
    ASSERT_EQ(geom_ids[0], geom_ids[1]);
    if (action == 2) attached[which] = geom_ids[0];
    if (random.below(3) != 0) continue;
    twice.commit();
    const std::vector<RTCRayHit> rays = random_rays(static_cast<std::uint32_t>(round), 100);
    for (RTCRayHit own : rays) {
      RTCRayHit reference = own;
      intersect_one(twice.our_scene, own);
      intersect_one(twice.native_scene, reference);
      expect_same_hit(own, reference);
    }
  }
  int side = 0;
  twice.both([&](const Embree& embree, RTCDevice, RTCScene) {
    for (const RTCGeometry g : geometries[side]) embree.rtcReleaseGeometry(g);
    ++side;
  });
}

TEST(PreloadContents, OneGeometryInSeveralScenesOutlivesItsHandles) {
  const Mesh mesh = triangle_soup(6, 100, 3);
  Twice twice;
  RTCScene second[2];
  int side = 0;
  twice.both([&](const Embree& embree, RTCDevice device, RTCScene scene) {
    second[side] = embree.rtcNewScene(device);
    const RTCGeometry geometry = new_mesh(embree, device, mesh);
    embree.rtcCommitGeometry(geometry);
    EXPECT_EQ(embree.rtcAttachGeometry(scene, geometry), 0u);
    EXPECT_EQ(embree.rtcAttachGeometry(second[side], geometry), 0u);
    embree.rtcAttachGeometryByID(second[side], geometry, 9);
    embree.rtcReleaseGeometry(geometry);
    embree.rtcCommitScene(scene);
    embree.rtcDetachGeometry(scene, 0);
    embree.rtcCommitScene(second[side]);
    embree.rtcCommitScene(scene);
    embree.rtcDetachGeometry(second[side], 0);
    embree.rtcCommitScene(second[side]);
    embree.rtcRetainGeometry(embree.rtcGetGeometry(second[side], 9));
    embree.rtcReleaseGeometry(embree.rtcGetGeometry(second[side], 9));
    ++side;
  });
  RTCBounds bounds;
  ours().rtcGetSceneBounds(twice.our_scene, &bounds);
  EXPECT_GT(bounds.lower_x, bounds.upper_x);  // empty
  expect_same_hits(second[0], second[1], random_rays(8, 1000));
  EXPECT_EQ(geom_id_hit(second[0], mesh.steps[0][0].x, mesh.steps[0][0].y, 0),
            geom_id_hit(second[1], mesh.steps[0][0].x, mesh.steps[0][0].y, 0));
  side = 0;
  twice.both([&](const Embree& embree, RTCDevice, RTCScene) { embree.rtcReleaseScene(second[side++]); });
}

}  // namespace
}  // namespace stbvh::preload_test
