#include "simd/f32x8_avx2.h"  // before the traversal, eight lanes, in twice as many registers

#include "harness/structures/gallery/method_kernels.inl"

namespace stbvh::harness::gallery {

const MethodKernels kAvx512Methods = make_method_kernels();

}  // namespace stbvh::harness::gallery
