/// What the environment variables mean, and what is said of a wrong one.
#include "plugin/preload/environment.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "plugin/preload/tracked_device.h"

namespace stbvh::preload {
namespace {

struct Read {
  Environment environment;
  std::vector<std::string> complaints;
};

Read read(const std::map<std::string, std::string>& variables) {
  Read result;
  result.environment = read_environment(
      [&](const char* name) {
        const auto found = variables.find(name);
        return found == variables.end() ? nullptr : found->second.c_str();
      },
      [&](const std::string& sentence) { result.complaints.push_back(sentence); });
  return result;
}

TEST(PreloadEnvironment, WithoutVariablesMovingMeshesAreTakenOver) {
  const Read r = read({});
  EXPECT_TRUE(r.environment.enabled);
  EXPECT_FALSE(r.environment.all_triangles);
  EXPECT_FALSE(r.environment.verbose);
  EXPECT_FALSE(r.environment.fast);
  EXPECT_EQ(r.environment.max_bytes, kNoLimit);
  EXPECT_FALSE(r.environment.statistics.has_value());
  EXPECT_TRUE(r.complaints.empty());
}

TEST(PreloadEnvironment, EachVariableDoesWhatItSays) {
  const Read r = read({{"STBVH_PRELOAD", "0"},
                       {"STBVH_PRELOAD_ALL", "1"},
                       {"STBVH_PRELOAD_VERBOSE", "1"},
                       {"STBVH_PRELOAD_PRESET", "fast"},
                       {"STBVH_PRELOAD_MAX_BYTES", "123456"},
                       {"STBVH_PRELOAD_STATISTICS", "out.json"}});
  EXPECT_FALSE(r.environment.enabled);
  EXPECT_TRUE(r.environment.all_triangles);
  EXPECT_TRUE(r.environment.verbose);
  EXPECT_TRUE(r.environment.fast);
  EXPECT_EQ(r.environment.max_bytes, 123456u);
  EXPECT_EQ(r.environment.statistics, "out.json");
  EXPECT_TRUE(r.complaints.empty());
  EXPECT_EQ(read({{"STBVH_PRELOAD_STATISTICS", "1"}}).environment.statistics, "");
  EXPECT_FALSE(read({{"STBVH_PRELOAD_STATISTICS", "0"}}).environment.statistics.has_value());
  EXPECT_FALSE(read({{"STBVH_PRELOAD_PRESET", "default"}}).environment.fast);
}

TEST(PreloadEnvironment, AWrongValueIsSaidInASentenceAndTheDefaultTaken) {
  const Read r =
      read({{"STBVH_PRELOAD", "yes"}, {"STBVH_PRELOAD_ALL", "2"}, {"STBVH_PRELOAD_PRESET", "small"}});
  EXPECT_TRUE(r.environment.enabled);
  EXPECT_FALSE(r.environment.all_triangles);
  EXPECT_FALSE(r.environment.fast);
  ASSERT_EQ(r.complaints.size(), 3u);
  EXPECT_EQ(r.complaints[0], "STBVH_PRELOAD must be 0 or 1, not 'yes'; it is taken as 1");
  EXPECT_EQ(r.complaints[2],
            "STBVH_PRELOAD_PRESET must be default or fast, not 'small'; it is taken as default");
}

TEST(PreloadEnvironment, AWrongNumberOfBytesIsSaidInASentenceAndThereIsNoLimit) {
  for (const char* bytes : {"0", "-1", "1e6", "12 ", "64M", "99999999999999999999999"}) {
    const Read r = read({{"STBVH_PRELOAD_MAX_BYTES", bytes}});
    EXPECT_EQ(r.environment.max_bytes, kNoLimit) << bytes;
    ASSERT_EQ(r.complaints.size(), 1u) << bytes;
    EXPECT_EQ(r.complaints[0], "STBVH_PRELOAD_MAX_BYTES must be a number of bytes, not '" +
                                   std::string(bytes) + "'; there is no limit");
  }
}

TEST(PreloadDevice, ThreadsOfItsConfiguration) {
  EXPECT_EQ(thread_limit_of(nullptr), 0);
  EXPECT_EQ(thread_limit_of(""), 0);
  EXPECT_EQ(thread_limit_of("threads=3"), 3);
  EXPECT_EQ(thread_limit_of("verbose=0, threads = 12 ,isa=avx2"), 12);
  EXPECT_EQ(thread_limit_of("user_threads=5"), 0);
  EXPECT_EQ(thread_limit_of("threads=all,start_threads=1"), 0);
  EXPECT_EQ(thread_limit_of("threads=-2"), 0);
}

}  // namespace
}  // namespace stbvh::preload
