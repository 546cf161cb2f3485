#include <xmmintrin.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include "layout/layout.h"
#include "stbvh/structure.h"
#include "traverse/kernel_table.h"

namespace stbvh {
namespace {
// In this order; the blank lines keep clang-format from sorting them.
#include "simd/f32x8_scalar.h"

#include "traverse/ray_setup.inl"

#include "traverse/leaf_test.inl"

#include "traverse/traverse.inl"
}  // namespace

const KernelTable kScalarKernels = make_kernel_table();

}  // namespace stbvh
