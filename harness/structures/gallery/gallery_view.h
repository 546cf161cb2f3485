/// What the traversals of the gallery see. It includes little: sources for one instruction set include it.
#pragma once

#include "layout/layout.h"
#include "stbvh/structure.h"

namespace stbvh::harness::gallery {

/// A structure, with what a method needs beside the block; null in the kernels' own nodes.
struct GalleryView : StructureView {
  const void* method = nullptr;
};

/// The entry points of one kind of nodes on one instruction set. Those of a method's own nodes are given a
/// GalleryView.
struct GalleryKernels {
  bool (*intersect)(const StructureView&, const Ray&, Hit&);
  bool (*intersect_counted)(const StructureView&, const Ray&, Hit&, TraversalCounters&);
  bool (*occluded)(const StructureView&, const Ray&);
};

/// Of all methods with nodes of their own: one member for each.
struct MethodKernels {
  GalleryKernels box_sequence;
  GalleryKernels slabs_12;
  GalleryKernels obb_linear;
};
extern const MethodKernels kScalarMethods;
extern const MethodKernels kAvx2Methods;
extern const MethodKernels kAvx512Methods;
/// Those of the instruction set that the kernels choose.
const MethodKernels& method_kernels();

}  // namespace stbvh::harness::gallery
