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

#include "traverse/leaf_vertices.inl"

#include "traverse/leaf_watertight.inl"

#include "traverse/leaf_fast.inl"

#include "traverse/traverse.inl"
}  // namespace

const KernelTables kScalarKernels = {make_kernel_table<WatertightTest>(), make_kernel_table<FastTest>()};

}  // namespace stbvh
