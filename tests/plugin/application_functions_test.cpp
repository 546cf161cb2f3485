// Embree 4: functions of the application that stand between a ray and our geometry. One that a query brings
// for all user geometries; and a user geometry of the application's own that forwards rays into a scene.
#include "tests/plugin/mesh_pair.h"

#if RTC_VERSION_MAJOR >= 4

namespace stbvh::test {
namespace {

constexpr unsigned kOwnId = 77;     // of our geometry in a scene_pair
constexpr unsigned kSheetId = 100;  // of the application's
constexpr float kSheetHeight = .25f;

/// The application's user geometry: a horizontal sheet that every ray meets.
void meet_sheet(RTCRayN* rays, unsigned size, unsigned i, const QueryContext& context, RTCHitN* hits) {
  const float t = (kSheetHeight - RTCRayN_org_z(rays, size, i)) / RTCRayN_dir_z(rays, size, i);
  if (!(t > RTCRayN_tnear(rays, size, i) && t <= RTCRayN_tfar(rays, size, i))) return;
  if (hits == nullptr) {
    RTCRayN_tfar(rays, size, i) = -std::numeric_limits<float>::infinity();
    return;
  }
  RTCRayN_tfar(rays, size, i) = t;
  RTCHitN_geomID(hits, size, i) = kSheetId;
  RTCHitN_primID(hits, size, i) = 0;
  RTCHitN_u(hits, size, i) = RTCHitN_v(hits, size, i) = 0;
  RTCHitN_Ng_x(hits, size, i) = RTCHitN_Ng_y(hits, size, i) = 0;
  RTCHitN_Ng_z(hits, size, i) = 1;
  RTCHitN_instID(hits, size, i, 0) = context.instID[0];
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  RTCHitN_instPrimID(hits, size, i, 0) = context.instPrimID[0];
#endif
}

void intersect_sheet(const RTCIntersectFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != 0)
      meet_sheet(RTCRayHitN_RayN(args->rayhit, args->N), args->N, i, *args->context,
                 RTCRayHitN_HitN(args->rayhit, args->N));
  }
}

void occlude_sheet(const RTCOccludedFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != 0) meet_sheet(args->ray, args->N, i, *args->context, nullptr);
  }
}

void intersect_any(const RTCIntersectFunctionNArguments* args) {
  args->geomID == kOwnId ? stbvhIntersectFunctionN(args) : intersect_sheet(args);
}

void occlude_any(const RTCOccludedFunctionNArguments* args) {
  args->geomID == kOwnId ? stbvhOccludedFunctionN(args) : occlude_sheet(args);
}

void intersect_sheet_alone(const RTCIntersectFunctionNArguments* args) {
  if (args->geomID == kSheetId) intersect_sheet(args);
}

void bounds_of_everything(const RTCBoundsFunctionArguments* args) {
  *args->bounds_o = RTCBounds{-9, -9, -9, 0, 9, 9, 9, 0};
}

/// A user geometry around everything; null functions: those that queries bring.
NativeGeometry user_geometry(const Device& device, void* user_data, RTCIntersectFunctionN intersect,
                             RTCOccludedFunctionN occluded) {
  NativeGeometry geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
  rtcSetGeometryUserData(geometry.get(), user_data);
  rtcSetGeometryBoundsFunction(geometry.get(), bounds_of_everything, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), intersect);
  rtcSetGeometryOccludedFunction(geometry.get(), occluded);
  rtcCommitGeometry(geometry.get());
  return geometry;
}

/// Three of four, by what was hit.
void reject_some(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != 0 && RTCHitN_primID(args->hit, args->N, i) % 4 != 0) args->valid[i] = 0;
  }
}

template <typename Packet, unsigned N>
void expect_same_packets(RTCScene native, RTCScene own, const QueryOptions& options) {
  Random random(N);
  for (unsigned round = 0; round < 1000 / N; ++round) {
    alignas(64) int valid[N];
    Packet rays{};
    for (unsigned i = 0; i < N; ++i) {
      valid[i] = random.below(4) == 0 ? 0 : -1;
      const RTCRayHit ray = random_ray(random);
      for (unsigned m = 0; m < kRayHitMembers; ++m)
        reinterpret_cast<float*>(&rays)[m * N + i] = reinterpret_cast<const float*>(&ray)[m];
    }
    Packet closest[2] = {rays, rays}, any[2] = {rays, rays};
    intersect_packet(valid, native, closest[0], options);
    intersect_packet(valid, own, closest[1], options);
    occluded_packet(valid, native, any[0], options);
    occluded_packet(valid, own, any[1], options);
    for (unsigned i = 0; i < N; ++i) {
      const auto lane = [i](Packet& packet) {
        return rtcGetRayHitFromRayHitN(reinterpret_cast<RTCRayHitN*>(&packet), N, i);
      };
      ASSERT_NO_FATAL_FAILURE(expect_same_hit(lane(closest[0]), lane(closest[1])));
      ASSERT_EQ(any[0].ray.tfar[i], any[1].ray.tfar[i]);
    }
  }
}

/// One ray and packets, with and without a filter.
void expect_same_answers(RTCScene native, RTCScene own, QueryOptions options) {
  for (const RTCFilterFunctionN filter : {RTCFilterFunctionN{}, RTCFilterFunctionN{reject_some}}) {
    options.filter = filter;
    Random random(1);
    unsigned hits_on_meshes = 0;
    for (unsigned i = 0; i < 2000; ++i) {
      const RTCRayHit ray = random_ray(random);
      const RTCRayHit expected = intersect(native, ray, options);
      ASSERT_NO_FATAL_FAILURE(expect_same_hit(expected, intersect(own, ray, options)));
      ASSERT_EQ(is_occluded(native, ray, options), is_occluded(own, ray, options));
      hits_on_meshes += expected.hit.geomID < kOwnId;
    }
    EXPECT_GT(hits_on_meshes, 100u);
    expect_same_packets<RTCRayHit4, 4>(native, own, options);
    expect_same_packets<RTCRayHit8, 8>(native, own, options);
    expect_same_packets<RTCRayHit16, 16>(native, own, options);
  }
}

class PluginQueryFunctions : public testing::Test {
 protected:
  void SetUp() override {
    const NativeGeometry sheet = user_geometry(device_, nullptr, nullptr, nullptr);
    for (const RTCScene scene : {pair_.native.get(), pair_.own.get()}) {
      rtcAttachGeometryByID(scene, sheet.get(), kSheetId);
      rtcCommitScene(scene);
    }
  }

  Device device_ = new_device();
  ScenePair pair_ = scene_pair(device_, {triangle_soup(1, 100, 5), triangle_soup(2, 100, 1)});
};

TEST_F(PluginQueryFunctions, PassOnWhatIsOurs) {
  expect_same_answers(pair_.native.get(), pair_.own.get(),
                      {.intersect = intersect_any, .occluded = occlude_any});
}

/// Embree asks the query's function instead of ours: nothing that we could change.
TEST_F(PluginQueryFunctions, ThatDoNotPassItOnHideIt) {
  const RTCRayHit ray = ray_down(.1f, .1f, .5f);
  const RTCRayHit hit = intersect(pair_.own.get(), ray, {.intersect = intersect_sheet_alone});
  EXPECT_EQ(hit.hit.geomID, kSheetId);
  Random random(1);
  unsigned hits_on_meshes = 0;
  for (unsigned i = 0; i < 500; ++i) {
    const QueryOptions options{.intersect = intersect_sheet_alone};
    hits_on_meshes += intersect(pair_.own.get(), random_ray(random), options).hit.geomID < kOwnId;
  }
  EXPECT_EQ(hits_on_meshes, 0u);
}

/// Moves rays as an instance of its own would.
template <typename Rays>
void shift(Rays& rays, unsigned size) {
  auto* const lanes = reinterpret_cast<RTCRayN*>(&rays);
  for (unsigned i = 0; i < size; ++i) RTCRayN_org_x(lanes, size, i) += .5f;
}

template <typename Rays, typename Arguments, typename Forward>
void forward_shifted(const Arguments* args, const void* rays, Forward&& forward) {
  Rays copy = *static_cast<const Rays*>(rays);
  shift(copy, args->N);
  forward(*static_cast<const RTCScene*>(args->geometryUserPtr), &copy);
}

constexpr unsigned kInstance = 5, kPrimitive = 6;

void forward_intersect(const RTCIntersectFunctionNArguments* args) {
  const void* const rays = args->rayhit;
  switch (args->N) {
    case 1:
      return forward_shifted<RTCRay>(args, rays, [=](RTCScene scene, RTCRay* ray) {
        rtcForwardIntersect1Ex(args, scene, ray, kInstance, kPrimitive);
      });
    case 4:
      return forward_shifted<RTCRay4>(args, rays, [=](RTCScene scene, RTCRay4* ray) {
        rtcForwardIntersect4Ex(args->valid, args, scene, ray, kInstance, kPrimitive);
      });
    case 8:
      return forward_shifted<RTCRay8>(args, rays, [=](RTCScene scene, RTCRay8* ray) {
        rtcForwardIntersect8Ex(args->valid, args, scene, ray, kInstance, kPrimitive);
      });
    default:
      return forward_shifted<RTCRay16>(args, rays, [=](RTCScene scene, RTCRay16* ray) {
        rtcForwardIntersect16Ex(args->valid, args, scene, ray, kInstance, kPrimitive);
      });
  }
}

void forward_occluded(const RTCOccludedFunctionNArguments* args) {
  const void* const rays = args->ray;
  switch (args->N) {
    case 1:
      return forward_shifted<RTCRay>(args, rays, [=](RTCScene scene, RTCRay* ray) {
        rtcForwardOccluded1Ex(args, scene, ray, kInstance, kPrimitive);
      });
    case 4:
      return forward_shifted<RTCRay4>(args, rays, [=](RTCScene scene, RTCRay4* ray) {
        rtcForwardOccluded4Ex(args->valid, args, scene, ray, kInstance, kPrimitive);
      });
    case 8:
      return forward_shifted<RTCRay8>(args, rays, [=](RTCScene scene, RTCRay8* ray) {
        rtcForwardOccluded8Ex(args->valid, args, scene, ray, kInstance, kPrimitive);
      });
    default:
      return forward_shifted<RTCRay16>(args, rays, [=](RTCScene scene, RTCRay16* ray) {
        rtcForwardOccluded16Ex(args->valid, args, scene, ray, kInstance, kPrimitive);
      });
  }
}

TEST(PluginForwardedRays, HitWhatEmbreesTrianglesWould) {
  const Device device = new_device();
  ScenePair pair = scene_pair(device, {triangle_soup(3, 100, 5), triangle_soup(4, 100, 1)});
  Scene tops[2];
  RTCScene below[2] = {pair.native.get(), pair.own.get()};
  for (unsigned i = 0; i < 2; ++i) {
    tops[i] = new_scene(device);
    const NativeGeometry forwarder = user_geometry(device, &below[i], forward_intersect, forward_occluded);
    rtcAttachGeometryByID(tops[i].get(), forwarder.get(), kSheetId);
    rtcCommitScene(tops[i].get());
  }
  expect_same_answers(tops[0].get(), tops[1].get(), {});
  Random random(2);
  for (unsigned i = 0; i < 500; ++i) {
    const RTCRayHit hit = intersect(tops[1].get(), random_ray(random));
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    EXPECT_EQ(hit.hit.instID[0], kInstance);
    EXPECT_EQ(hit.hit.instPrimID[0], kPrimitive);
  }
}

}  // namespace
}  // namespace stbvh::test

#endif
