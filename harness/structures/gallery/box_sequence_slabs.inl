/// The test of a node of box sequences. It includes little: sources for one instruction set include it.
#pragma once

#include "harness/structures/gallery/box_sequence_node.h"
#include "harness/structures/gallery/gallery_view.h"
#include "traverse/steps.inl"

namespace stbvh::harness::gallery {
namespace {

class BoxSequenceSlabs : public KeptSlabs {
 public:
  BoxSequenceSlabs(const GalleryView&, const TraversalRay& ray) : KeptSlabs(ray) {}
};

template <typename Test>
inline ChildHits intersect_any_node(const TraversalRay& ray, const BoxSequenceSlabs& slabs, LinkKind,
                                    const std::byte* data, const Link*& children) {
  const auto& node = *reinterpret_cast<const BoxSequenceNode*>(data);
  children = node.children;
  const StepBoxes* const steps = steps_of(node);
  if (node.segments == 0)
    return intersect_children<Test>(ray, slabs,
                                    [&](std::uint32_t offset) { return load(plane(steps, offset)); });
  const SegmentTime at = segment_at(node, ray.time);
  const StepBoxes* const begin = steps + at.segment;
  const F32x8 of_begin = splat(1.0f - at.fraction), of_end = splat(at.fraction);
  // Each plane is off by at most 3 roundings of itself at either step, by its share: less than they are
  // padded.
  return intersect_children<Test>(ray, slabs, [&](std::uint32_t offset) {
    return multiply_add(of_end, load(plane(begin + 1, offset)), of_begin * load(plane(begin, offset)));
  });
}

}  // namespace
}  // namespace stbvh::harness::gallery
