#include "simd/f32x8_avx2.h"  // before the traversal: eight lanes, in twice as many registers

#include "traverse/kernel_table.inl"

namespace stbvh {

const KernelTables kAvx512Kernels = {make_kernel_table<WatertightTest>(), make_kernel_table<FastTest>()};

}  // namespace stbvh
