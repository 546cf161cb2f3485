/// The entry points of all methods with nodes of their own, on one instruction set.
#pragma once

#include "harness/structures/gallery/traverse.inl"

namespace stbvh::harness::gallery {
namespace {

constexpr MethodKernels make_method_kernels() {
  return {};
}

}  // namespace
}  // namespace stbvh::harness::gallery
