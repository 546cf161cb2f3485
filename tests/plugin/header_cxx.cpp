// The header alone, first, as C++.
#include <stbvh/stbvh_embree.h>

#include <gtest/gtest.h>

extern "C" size_t stbvh_test_mesh_arguments_size_in_c();
extern "C" unsigned stbvh_test_default_mask_in_c();

TEST(PluginHeader, IsTheSameInCAndCxx) {
  EXPECT_EQ(stbvh_test_mesh_arguments_size_in_c(), sizeof(StbvhMeshArguments));
  EXPECT_EQ(stbvh_test_default_mask_in_c(), STBVH_DEFAULT_MASK);
}
