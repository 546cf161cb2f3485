// Bad arguments: one clear sentence, nothing changed, no crash.
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

class PluginArguments : public testing::Test {
 protected:
  void expect_refused(const std::function<void(StbvhMeshArguments&)>& spoil, const std::string& word) {
    SCOPED_TRACE(word);
    StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
    spoil(arguments);
    unsigned index = 42;
    EXPECT_EQ(stbvhAddMesh(geometry_.get(), &arguments, &index), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(stbvhGetErrorMessage(geometry_.get())).find(word), std::string::npos)
        << stbvhGetErrorMessage(geometry_.get());
    EXPECT_EQ(index, 42u);
    EXPECT_EQ(stbvhGetMeshCount(geometry_.get()), 0u);
  }

  Device device_ = new_device();
  OwnGeometry geometry_{stbvhNewGeometry(device_.get())};
  TestMesh mesh_ = flat_triangle(0, 3);
  std::vector<const void*> pointers_;
};

TEST_F(PluginArguments, OfMeshes) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  EXPECT_STREQ(stbvhGetErrorMessage(geometry_.get()), "");
  expect_refused([](auto& a) { a.byteSize = 0; }, "byteSize");
  expect_refused([](auto& a) { a.byteSize += 8; }, "byteSize");
  expect_refused([](auto& a) { a.stepCount = 0; }, "stepCount must be 1 to 4096, not 0");
  expect_refused([](auto& a) { a.stepCount = 4097; }, "not 4097");
  expect_refused([](auto& a) { a.indices = nullptr; }, "indices");
  expect_refused([](auto& a) { a.indices = static_cast<const char*>(a.indices) + 1; }, "aligned");
  expect_refused([](auto& a) { a.indexByteStride = 8; }, "indexByteStride");
  expect_refused([](auto& a) { a.indexByteStride = 13; }, "indexByteStride");
  expect_refused([](auto& a) { a.vertices = nullptr; }, "vertices is null");
  expect_refused([this](auto&) { pointers_[1] = nullptr; }, "vertices[1] is null");
  expect_refused([this](auto&) { pointers_[2] = static_cast<const char*>(pointers_[2]) + 2; }, "vertices[2]");
  expect_refused([](auto& a) { a.vertexByteStride = 0; }, "vertexByteStride");
  const std::size_t strides[3] = {12, 16, 11};
  expect_refused([&](auto& a) { a.vertexByteStrides = strides; }, "vertexByteStrides[2]");
  expect_refused([&](auto& a) { a.startTime = nan; }, "finite");
  expect_refused([&](auto& a) { a.endTime = infinity; }, "finite");
  expect_refused([](auto& a) { a.endTime = a.startTime; }, "smaller");
  expect_refused([](auto& a) { a.startTime = 2; }, "smaller");
  expect_refused([](auto& a) { a.startTime = -3e38f, a.endTime = 3e38f; }, "too long");
  expect_refused([](auto& a) { a.vertexCount = std::size_t{1} << 33; }, "32 bits");
  expect_refused([](auto& a) { a.triangleCount = std::size_t{1} << 33; }, "32 bits");
}

/// Before anything is read through them.
TEST_F(PluginArguments, ThatReachBeyondMemory) {
  constexpr std::size_t kBack = static_cast<std::size_t>(-12);
  constexpr std::size_t kHalf = std::size_t{1} << 62;
  expect_refused([](auto& a) { a.indexByteStride = kBack; },
                 "indexByteStride must be a multiple of 4 from 12");
  expect_refused([](auto& a) { a.vertexByteStride = kBack; }, "vertexByteStride must be");
  const std::size_t strides[3] = {12, kBack, 12};
  expect_refused([&](auto& a) { a.vertexByteStrides = strides; }, "vertexByteStrides[1] must be");
  expect_refused([](auto& a) { a.indexByteStride = kHalf, a.triangleCount = 5; },
                 "indices that reach beyond");
  expect_refused([](auto& a) { a.vertexByteStride = kHalf; }, "vertices that reach beyond");
  expect_refused([](auto& a) { a.vertexByteStride = kHalf, a.vertexCount = 5; },
                 "vertices that reach beyond");
  const void* const last = reinterpret_cast<const void*>(~std::uintptr_t{7});
  expect_refused([=](auto& a) { a.indices = last; }, "indices that reach beyond");
  expect_refused([=, this](auto&) { pointers_[2] = last; }, "vertices that reach beyond");
}

TEST_F(PluginArguments, ThatAreMisalignedArrays) {
  const auto shifted = [](auto* array) {
    return reinterpret_cast<decltype(array)>(reinterpret_cast<std::uintptr_t>(array) + 4);
  };
  const std::size_t strides[4] = {12, 12, 12, 12};
  expect_refused([&](auto& a) { a.vertices = shifted(a.vertices); }, "vertices must be aligned to 8 bytes");
  expect_refused([&](auto& a) { a.vertexByteStrides = shifted(strides); },
                 "vertexByteStrides must be aligned to 8 bytes");
}

/// A time range that a commit could not divide up: the meshes that are there already stay.
TEST_F(PluginArguments, TimeRangesNextToEmpty) {
  constexpr float kLeast = std::numeric_limits<float>::min();
  expect_refused([](auto& a) { a.endTime = 1e-39f; }, "time range");
  expect_refused([](auto& a) { a.startTime = -1e-39f, a.endTime = 1e-39f; }, "time range");
  expect_refused([](auto& a) { a.startTime = kLeast, a.endTime = 1.5f * kLeast; }, "time range");
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE);
  StbvhMeshArguments narrow = arguments;
  narrow.endTime = 1e-39f;
  EXPECT_EQ(stbvhAddMesh(geometry_.get(), &narrow, nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhSetMesh(geometry_.get(), 0, &narrow), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_INVALID_ARGUMENT);
  // Of one step it does not matter, and the narrowest is built.
  narrow.geomID = 1;
  narrow.stepCount = 1;
  EXPECT_EQ(stbvhAddMesh(geometry_.get(), &narrow, nullptr), RTC_ERROR_NONE);
  narrow.geomID = 2;
  narrow.stepCount = 3;
  narrow.endTime = kLeast;
  EXPECT_EQ(stbvhAddMesh(geometry_.get(), &narrow, nullptr), RTC_ERROR_NONE);
  narrow.geomID = 3;
  narrow.startTime = std::nextafter(1.0f, 0.0f), narrow.endTime = 1;
  EXPECT_EQ(stbvhAddMesh(geometry_.get(), &narrow, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE) << stbvhGetErrorMessage(geometry_.get());
  const Scene scene = new_scene(device_);
  rtcAttachGeometryByID(scene.get(), stbvhGetGeometry(geometry_.get()), 0);
  rtcCommitScene(scene.get());
  EXPECT_LE(intersect(scene.get(), ray_down(.1f, .1f, .5f)).hit.geomID, 1u);  // two lie there
  EXPECT_EQ(rtcGetDeviceError(device_.get()), RTC_ERROR_NONE);
}

TEST_F(PluginArguments, PrecisionThatIsNotListed) {
  for (const unsigned value : {2u, 7u, ~0u}) {
    EXPECT_EQ(stbvhSetGeometryPrecision(geometry_.get(), static_cast<StbvhPrecision>(value)),
              RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_STREQ(stbvhGetErrorMessage(geometry_.get()), "precision is not one of enum StbvhPrecision");
  }
  EXPECT_EQ(stbvhSetGeometryPrecision(geometry_.get(), STBVH_PRECISION_FAST), RTC_ERROR_NONE);
}

TEST_F(PluginArguments, Null) {
  EXPECT_EQ(stbvhAddMesh(geometry_.get(), nullptr, nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhSetMesh(geometry_.get(), 0, nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhGetMesh(geometry_.get(), 0, nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhGetStatistics(geometry_.get(), nullptr), RTC_ERROR_INVALID_ARGUMENT);
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  EXPECT_EQ(stbvhAddMesh(nullptr, &arguments, nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhSetMesh(nullptr, 0, &arguments), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhGetMesh(nullptr, 0, &arguments), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhCommitGeometry(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhSetGeometryPrecision(nullptr, STBVH_PRECISION_FAST), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhSetGeometryMaxBytes(nullptr, 1, 1), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhSetGeometryTolerance(nullptr, 0.0f), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhSetGeometryProgressFunction(nullptr, nullptr, nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhGetGeometry(nullptr), nullptr);
  EXPECT_EQ(stbvhGetMeshCount(nullptr), 0u);
  EXPECT_STREQ(stbvhGetErrorMessage(nullptr), "geometry is null");
  EXPECT_EQ(stbvhNewGeometry(nullptr), nullptr);
  EXPECT_STREQ(stbvhGetErrorMessage(nullptr), "device is null");
  stbvhRetainGeometry(nullptr);
  stbvhReleaseGeometry(nullptr);
}

TEST_F(PluginArguments, ToleranceOutOfRange) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float tolerance : {-0.5f, -2.0f, nan, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(stbvhSetGeometryTolerance(geometry_.get(), tolerance), RTC_ERROR_INVALID_ARGUMENT) << tolerance;
  }
  for (const float tolerance : {0.0f, 1e-3f, STBVH_KEEP_ALL_STEPS}) {
    EXPECT_EQ(stbvhSetGeometryTolerance(geometry_.get(), tolerance), RTC_ERROR_NONE) << tolerance;
  }
}

TEST_F(PluginArguments, StepTimesThatDoNotIncrease) {
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  ASSERT_GE(arguments.stepCount, 2u);
  std::vector<float> times(arguments.stepCount);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = static_cast<float>(i * i);
  arguments.stepTimes = times.data();
  arguments.startTime = arguments.endTime = std::numeric_limits<float>::quiet_NaN();  // not looked at
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE)
      << stbvhGetErrorMessage(geometry_.get());
  StbvhMeshArguments read;
  stbvhInitMeshArguments(&read);
  ASSERT_EQ(stbvhGetMesh(geometry_.get(), 0, &read), RTC_ERROR_NONE);
  ASSERT_NE(read.stepTimes, times.data());
  EXPECT_TRUE(std::equal(times.begin(), times.end(), read.stepTimes));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float bad : {times[0], -1.0f, 1e-40f, nan, std::numeric_limits<float>::infinity()}) {
    times[1] = bad;
    EXPECT_EQ(stbvhSetMesh(geometry_.get(), 0, &arguments), RTC_ERROR_INVALID_ARGUMENT) << bad;
    EXPECT_NE(std::string(stbvhGetErrorMessage(geometry_.get())).find("step times"), std::string::npos);
  }
  EXPECT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
}

TEST_F(PluginArguments, MeshIndexOutOfRange) {
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE);
  EXPECT_EQ(stbvhSetMesh(geometry_.get(), 1, &arguments), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stbvhGetMesh(geometry_.get(), 1, &arguments), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_STREQ(stbvhGetErrorMessage(geometry_.get()), "meshIndex is 1, but there are 1 meshes");
}

TEST_F(PluginArguments, AreReadBack) {
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  arguments.mask = 6;
  arguments.geomID = 9;
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE);
  StbvhMeshArguments copy;
  copy.byteSize = sizeof(copy);
  ASSERT_EQ(stbvhGetMesh(geometry_.get(), 0, &copy), RTC_ERROR_NONE);
  EXPECT_EQ(copy.mask, 6u);
  EXPECT_EQ(copy.geomID, 9u);
  EXPECT_EQ(copy.stepCount, 3u);
  EXPECT_EQ(copy.vertices[2], mesh_.steps[2].data());
  EXPECT_EQ(copy.vertexByteStrides[2], 12u);
  ASSERT_EQ(stbvhSetMesh(geometry_.get(), 0, &copy), RTC_ERROR_NONE);  // its arrays are the handle's own
  ASSERT_EQ(stbvhGetMesh(geometry_.get(), 0, &copy), RTC_ERROR_NONE);
  EXPECT_EQ(copy.vertices[2], mesh_.steps[2].data());
}

/// Commits, attaches and traces: nothing may be hit, and nothing may go wrong.
void expect_no_hits(const Device& device, const OwnGeometry& geometry) {
  ASSERT_EQ(stbvhCommitGeometry(geometry.get()), RTC_ERROR_NONE) << stbvhGetErrorMessage(geometry.get());
  const Scene scene = new_scene(device);
  rtcAttachGeometry(scene.get(), stbvhGetGeometry(geometry.get()));
  rtcCommitScene(scene.get());
  Random random(1);
  for (unsigned i = 0; i < 100; ++i) {
    EXPECT_EQ(intersect(scene.get(), random_ray(random)).hit.geomID, RTC_INVALID_GEOMETRY_ID);
    EXPECT_FALSE(is_occluded(scene.get(), random_ray(random)));
  }
  EXPECT_EQ(rtcGetDeviceError(device.get()), RTC_ERROR_NONE);
}

TEST_F(PluginArguments, NoMeshesOrEmptyOnesAreAnEmptyGeometry) {
  expect_no_hits(device_, geometry_);
  StbvhMeshArguments empty;
  stbvhInitMeshArguments(&empty);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &empty, nullptr), RTC_ERROR_NONE);
  empty.stepCount = 7;
  empty.geomID = 1;
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &empty, nullptr), RTC_ERROR_NONE);
  StbvhMeshArguments without_vertices = arguments_of(mesh_, pointers_);
  without_vertices.vertexCount = 0;
  without_vertices.geomID = 2;
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &without_vertices, nullptr), RTC_ERROR_NONE);
  expect_no_hits(device_, geometry_);
}

TEST_F(PluginArguments, MeshesOfInvalidTrianglesAreAnEmptyGeometry) {
  for (auto& step : mesh_.steps) step[1].x = std::numeric_limits<float>::quiet_NaN();
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE);
  expect_no_hits(device_, geometry_);
}

/// Of Embree, when it commits a scene.
struct SceneErrors {
  static void keep(void* self, RTCError code, const char* message) {
    static_cast<SceneErrors*>(self)->seen.emplace_back(code, message);
  }
  explicit SceneErrors(const Device& own_device) : device(own_device) {
    rtcSetDeviceErrorFunction(device.get(), keep, this);
  }

  std::vector<std::pair<RTCError, std::string>> of_commit(const Scene& scene) {
    seen.clear();
    rtcCommitScene(scene.get());
    rtcGetDeviceError(device.get());
    return seen;
  }

  const Device& device;
  std::vector<std::pair<RTCError, std::string>> seen;
};

/// Whatever is not committed, Embree says of ours what it says of its own.
TEST_F(PluginArguments, EmbreeRefusesScenesWithAGeometryThatIsNotCommitted) {
  SceneErrors errors(device_);
  const Scene native = new_scene(device_), own = new_scene(device_);
  const NativeGeometry triangles(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcAttachGeometry(native.get(), triangles.get());
  rtcAttachGeometry(own.get(), stbvhGetGeometry(geometry_.get()));
  const auto refusal = errors.of_commit(native);
  ASSERT_FALSE(refusal.empty());
  EXPECT_EQ(refusal[0].first, RTC_ERROR_INVALID_OPERATION);
  EXPECT_EQ(errors.of_commit(own), refusal);  // without a mesh
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_NONE);
  EXPECT_EQ(errors.of_commit(own), refusal);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  EXPECT_TRUE(errors.of_commit(own).empty());
  EXPECT_NE(intersect(own.get(), ray_down(.1f, .1f, .5f)).hit.geomID, RTC_INVALID_GEOMETRY_ID);
}

TEST_F(PluginArguments, EmbreeRefusesScenesWithAGeometryThatChangedSince) {
  SceneErrors errors(device_);
  const Scene scene = new_scene(device_);
  rtcAttachGeometry(scene.get(), stbvhGetGeometry(geometry_.get()));
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  arguments.geomID = 0;
  const StbvhGeometry g = geometry_.get();
  const std::function<RTCError()> changes[] = {
      [&] { return stbvhAddMesh(g, &arguments, nullptr); },
      [&] { return stbvhSetMesh(g, 0, &arguments); },
      [&] { return stbvhSetGeometryPrecision(g, STBVH_PRECISION_FAST); },
      [&] { return stbvhSetGeometryMaxBytes(g, 1 << 20, STBVH_NO_LIMIT); },
      [&] { return stbvhSetGeometryTolerance(g, 0.5f); },
  };
  for (const auto& change : changes) {
    ASSERT_EQ(stbvhCommitGeometry(g), RTC_ERROR_NONE);
    EXPECT_TRUE(errors.of_commit(scene).empty());
    ASSERT_EQ(change(), RTC_ERROR_NONE);
    const auto refusal = errors.of_commit(scene);
    ASSERT_FALSE(refusal.empty());
    EXPECT_EQ(refusal[0].first, RTC_ERROR_INVALID_OPERATION);
    EXPECT_EQ(intersect(scene.get(), ray_down(.1f, .1f, .5f)).hit.geomID, RTC_INVALID_GEOMETRY_ID);
  }
  // What is refused changes nothing.
  ASSERT_EQ(stbvhCommitGeometry(g), RTC_ERROR_NONE);
  arguments.stepCount = 0;
  ASSERT_NE(stbvhAddMesh(g, &arguments, nullptr), RTC_ERROR_NONE);
  ASSERT_NE(stbvhSetMesh(g, 0, &arguments), RTC_ERROR_NONE);
  EXPECT_TRUE(errors.of_commit(scene).empty());
  EXPECT_NE(intersect(scene.get(), ray_down(.1f, .1f, .5f)).hit.geomID, RTC_INVALID_GEOMETRY_ID);
}

}  // namespace
}  // namespace stbvh::test
