// Programs that were compiled with an older or a newer header than the library: their structs are shorter, or
// longer.
#include <cstddef>
#include <cstring>

#include "tests/plugin/mesh_pair.h"

namespace stbvh::test {
namespace {

constexpr std::size_t kOldArguments = offsetof(StbvhMeshArguments, geomID);
constexpr std::size_t kOldStatistics = offsetof(StbvhStatistics, structureBytes);

class PluginVersions : public testing::Test {
 protected:
  /// The arguments as a header wrote them that ends after `size` bytes; behind them stands something else.
  StbvhMeshArguments old_arguments(std::size_t size) {
    StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
    arguments.mask = 6;
    arguments.byteSize = size;
    std::memset(reinterpret_cast<char*>(&arguments) + size, 0x5A, sizeof(arguments) - size);
    return arguments;
  }

  StbvhMeshArguments read_back() {
    StbvhMeshArguments arguments;
    arguments.byteSize = sizeof(arguments);
    EXPECT_EQ(stbvhGetMesh(geometry_.get(), 0, &arguments), RTC_ERROR_NONE);
    return arguments;
  }

  Device device_ = new_device();
  OwnGeometry geometry_{stbvhNewGeometry(device_.get())};
  TestMesh mesh_ = flat_triangle(0, 3);
  std::vector<const void*> pointers_;
};

TEST_F(PluginVersions, MembersThatAnOlderHeaderDoesNotHaveKeepTheirDefaults) {
  const StbvhMeshArguments given = old_arguments(kOldArguments);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &given, nullptr), RTC_ERROR_NONE);
  const StbvhMeshArguments read = read_back();
  EXPECT_EQ(read.byteSize, sizeof(StbvhMeshArguments));
  EXPECT_EQ(read.stepCount, 3u);
  EXPECT_EQ(read.mask, 6u);
  EXPECT_EQ(read.geomID, RTC_INVALID_GEOMETRY_ID);
  EXPECT_EQ(read.userPtr, nullptr);
  EXPECT_EQ(read.intersectFilter, nullptr);
  EXPECT_EQ(read.occludedFilter, nullptr);
}

TEST_F(PluginVersions, AMeshOfAnOlderHeaderIsBuiltAndHit) {
  const StbvhMeshArguments given = old_arguments(kOldArguments);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &given, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhSetMesh(geometry_.get(), 0, &given), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  const Scene scene = new_scene(device_);
  const unsigned id = rtcAttachGeometry(scene.get(), stbvhGetGeometry(geometry_.get()));
  rtcCommitScene(scene.get());
  EXPECT_EQ(intersect(scene.get(), ray_down(.1f, .1f, .5f)).hit.geomID, id);
}

TEST_F(PluginVersions, AHeaderWithoutFiltersHasAnIDOfItsOwn) {
  StbvhMeshArguments given = old_arguments(offsetof(StbvhMeshArguments, userPtr));
  given.geomID = 12;
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &given, nullptr), RTC_ERROR_NONE);
  EXPECT_EQ(read_back().geomID, 12u);
  EXPECT_EQ(read_back().userPtr, nullptr);
}

TEST_F(PluginVersions, ReadingBackWritesNothingBehindAnOlderStruct) {
  const StbvhMeshArguments given = old_arguments(kOldArguments);
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &given, nullptr), RTC_ERROR_NONE);
  StbvhMeshArguments read;
  std::memset(&read, 0x11, sizeof(read));
  read.byteSize = kOldArguments;
  ASSERT_EQ(stbvhGetMesh(geometry_.get(), 0, &read), RTC_ERROR_NONE);
  EXPECT_EQ(read.byteSize, kOldArguments);
  EXPECT_EQ(read.mask, 6u);
  for (std::size_t i = kOldArguments; i < sizeof(read); ++i)
    EXPECT_EQ(reinterpret_cast<const char*>(&read)[i], 0x11) << i;
}

TEST_F(PluginVersions, StatisticsOfAnOlderHeader) {
  const StbvhMeshArguments given = old_arguments(sizeof(given));
  ASSERT_EQ(stbvhAddMesh(geometry_.get(), &given, nullptr), RTC_ERROR_NONE);
  ASSERT_EQ(stbvhCommitGeometry(geometry_.get()), RTC_ERROR_NONE);
  StbvhStatistics statistics{.byteSize = kOldStatistics,
                             .triangles = 7,
                             .invalidTriangles = 7,
                             .primitiveSegments = 7,
                             .structureBytes = 7,
                             .peakBytes = 7,
                             .stepsGiven = 7,
                             .stepsKept = 7,
                             .maxDeviation = 7,
                             .wantedBytes = 7,
                             .leaves = 7,
                             .indexedLeaves = 7,
                             .isUpdate = 7,
                             .meshesRefitted = 7,
                             .meshesBuilt = 7,
                             .meshesRemoved = 7,
                             .leavesRefitted = 7,
                             .expectedCost = 7,
                             .commitSeconds = 7};
  ASSERT_EQ(stbvhGetStatistics(geometry_.get(), &statistics), RTC_ERROR_NONE);
  EXPECT_EQ(statistics.byteSize, kOldStatistics);
  EXPECT_EQ(statistics.triangles, 1u);
  EXPECT_EQ(statistics.primitiveSegments, 1u);  // it stands still in its three steps
  EXPECT_EQ(statistics.structureBytes, 7u);
  EXPECT_EQ(statistics.peakBytes, 7u);
}

TEST(PluginVersion, TheLibrarysIsThatOfItsHeader) {
  EXPECT_EQ(stbvhGetVersion(), STBVH_VERSION);
  EXPECT_EQ(std::to_string(STBVH_VERSION_MAJOR) + "." + std::to_string(STBVH_VERSION_MINOR) + "." +
                std::to_string(STBVH_VERSION_PATCH),
            STBVH_VERSION_STRING);
  EXPECT_EQ(stbvhGetVersion() / 10000, STBVH_VERSION_MAJOR);
  EXPECT_EQ(stbvhGetVersion() / 100 % 100, STBVH_VERSION_MINOR);
  EXPECT_EQ(stbvhGetVersion() % 100, STBVH_VERSION_PATCH);
}

TEST(PluginVersion, StatisticsAreInitialised) {
  StbvhStatistics statistics;
  std::memset(&statistics, 0x11, sizeof(statistics));
  stbvhInitStatistics(&statistics);
  const StbvhStatistics expected{.byteSize = sizeof(StbvhStatistics),
                                 .triangles = 0,
                                 .invalidTriangles = 0,
                                 .primitiveSegments = 0,
                                 .structureBytes = 0,
                                 .peakBytes = 0,
                                 .stepsGiven = 0,
                                 .stepsKept = 0,
                                 .maxDeviation = 0,
                                 .wantedBytes = 0,
                                 .leaves = 0,
                                 .indexedLeaves = 0,
                                 .isUpdate = 0,
                                 .meshesRefitted = 0,
                                 .meshesBuilt = 0,
                                 .meshesRemoved = 0,
                                 .leavesRefitted = 0,
                                 .expectedCost = 0,
                                 .commitSeconds = 0};
  EXPECT_EQ(std::memcmp(&statistics, &expected, sizeof(expected)), 0);
}

TEST_F(PluginVersions, SizesThatNoHeaderHasAreRefused) {
  StbvhMeshArguments arguments = arguments_of(mesh_, pointers_);
  for (const std::size_t size : {std::size_t{0}, std::size_t{8}, kOldArguments - 8, kOldArguments + 1,
                                 sizeof(arguments) - 4, sizeof(arguments) + 8, ~std::size_t{0}}) {
    arguments.byteSize = size;
    EXPECT_EQ(stbvhAddMesh(geometry_.get(), &arguments, nullptr), RTC_ERROR_INVALID_ARGUMENT) << size;
    EXPECT_NE(std::string(stbvhGetErrorMessage(geometry_.get())).find(std::to_string(size)),
              std::string::npos)
        << stbvhGetErrorMessage(geometry_.get());
    StbvhStatistics statistics{};
    statistics.byteSize = size;
    if (size < 16 || size > sizeof(statistics) || size % 8 != 0) {
      EXPECT_EQ(stbvhGetStatistics(geometry_.get(), &statistics), RTC_ERROR_INVALID_ARGUMENT) << size;
    }
  }
  EXPECT_EQ(stbvhGetMeshCount(geometry_.get()), 0u);
}

}  // namespace
}  // namespace stbvh::test
