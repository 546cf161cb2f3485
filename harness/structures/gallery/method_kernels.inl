/// The entry points of all methods with nodes of their own, on one instruction set.
#pragma once

#include "harness/structures/gallery/box_sequence_slabs.inl"
#include "harness/structures/gallery/obb_linear_nodes.inl"
#include "harness/structures/gallery/slabs_12_nodes.inl"
#include "harness/structures/gallery/traverse.inl"

namespace stbvh::harness::gallery {
namespace {

constexpr MethodKernels make_method_kernels() {
  return {.box_sequence = make_kernels<BoxSequenceSlabs>(),
          .slabs_12 = make_kernels<Slabs12>(),
          .obb_linear = make_kernels<ObbSlabs>()};
}

}  // namespace
}  // namespace stbvh::harness::gallery
