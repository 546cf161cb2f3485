/// The builder of all methods that do not split time.
#pragma once

#include "harness/structures/gallery/top_down.h"

namespace stbvh::harness::gallery {

/// Object splits alone, by linear bounds over the whole shutter.
class ObjectSplits : public TopDown {
 public:
  using TopDown::TopDown;

 private:
  std::optional<Split> choose(const ReferenceSet& set) const override {
    if (set.size() == 1) return std::nullopt;
    return find_object_split(set);
  }
};

}  // namespace stbvh::harness::gallery
