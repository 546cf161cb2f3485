#include "harness/structures/gallery/method_kernels.inl"

namespace stbvh::harness::gallery {

const MethodKernels kScalarMethods = make_method_kernels();

}  // namespace stbvh::harness::gallery
