/* The header must compile as C99 with all warnings, and its structs must be as in C++ (header_cxx.cpp
 * compares). */
#include <stbvh/stbvh_embree.h>

size_t stbvh_test_mesh_arguments_size_in_c(void);
unsigned int stbvh_test_default_mask_in_c(void);

size_t stbvh_test_mesh_arguments_size_in_c(void) {
  return sizeof(struct StbvhMeshArguments);
}

unsigned int stbvh_test_default_mask_in_c(void) {
  struct StbvhMeshArguments arguments;
  stbvhInitMeshArguments(&arguments);
  return arguments.byteSize == sizeof arguments ? arguments.mask : 0;
}
