/// The entry points of all methods with nodes of their own, on one instruction set.
#pragma once

#include "harness/structures/gallery/box_sequence_slabs.inl"
#include "harness/structures/gallery/traverse.inl"

namespace stbvh::harness::gallery {
namespace {

constexpr MethodKernels make_method_kernels() {
  return {.box_sequence = make_kernels<BoxSequenceSlabs>()};
}

}  // namespace
}  // namespace stbvh::harness::gallery
