/// The entry points of one instruction set.
#pragma once

#include <cstddef>

#include "layout/layout.h"
#include "stbvh/structure.h"

namespace stbvh {

/// Ray `i` of `batch`. Internal linkage on purpose: this is compiled for several instruction sets.
static inline const Ray& ray_at(const RayBatch& batch, std::size_t i) {
  return *reinterpret_cast<const Ray*>(static_cast<const std::byte*>(batch.rays) + batch.stride * i);
}

/// Closest hit and any hit, plain, with a filter, counted, and of many rays in flight. `hit` is written only
/// on a hit.
struct KernelTable {
  bool (*intersect)(const StructureView&, const Ray&, Hit&);
  bool (*intersect_filtered)(const StructureView&, const Ray&, Hit&, const HitFilter&);
  bool (*intersect_counted)(const StructureView&, const Ray&, Hit&, TraversalCounters&);
  void (*intersect_in_flight)(const StructureView&, const RayBatch&);
  bool (*occluded)(const StructureView&, const Ray&);
  bool (*occluded_filtered)(const StructureView&, const Ray&, const HitFilter&);
  bool (*occluded_counted)(const StructureView&, const Ray&, TraversalCounters&);
  void (*occluded_in_flight)(const StructureView&, const RayBatch&);
};

/// The tables of one instruction set.
struct KernelTables {
  KernelTable watertight;
  KernelTable fast;
};

/// The table of an instruction set that is available (available_isas()).
const KernelTable& kernel_table(Isa isa, Precision precision);

extern const KernelTables kScalarKernels;
extern const KernelTables kAvx2Kernels;
extern const KernelTables kAvx512Kernels;

}  // namespace stbvh
