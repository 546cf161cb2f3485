#include "simd/f32x8_avx2.h"  // before the traversal, which is then made of it

#include "traverse/kernel_table.inl"

namespace stbvh {

const KernelTables kAvx2Kernels = {make_kernel_table<WatertightTest>(), make_kernel_table<FastTest>()};

}  // namespace stbvh
