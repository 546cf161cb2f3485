#include "simd/f32x8_avx2.h"  // before the traversal, which is then made of it

#include "harness/structures/gallery/method_kernels.inl"

namespace stbvh::harness::gallery {

const MethodKernels kAvx2Methods = make_method_kernels();

}  // namespace stbvh::harness::gallery
