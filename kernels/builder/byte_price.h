/// What memory has to bring: the expected area, SA'(bounds) * T(range), that each byte must save. One price
/// holds for the whole tree, so that memory goes where rays profit most from it.
#pragma once

#include <algorithm>
#include <cstddef>

#include "builder/mbsah.h"
#include "layout/layout.h"

namespace stbvh {

/// What one more leaf adds to the nodes above it: a linear node, whose children are five more than it is.
inline constexpr std::size_t kNodeShareBytes = sizeof(LinearNode) / 5;
inline constexpr std::size_t kStaticNodeShareBytes = sizeof(StaticNode) / 5;

struct BytePrice {
  float area_per_byte = 0.0f;
  bool may_index = false;  ///< leaves may read the caller's buffers instead of holding vertices

  /// Of a leaf over `steps` steps that rays meet with `expected_area`, in expected area: of the cheaper kind.
  float of_leaf(float expected_area, std::size_t steps) const {
    const float held = expected_area * kLeafCost + of_bytes(inline_leaf_bytes(steps));
    return may_index ? std::min(held, expected_area * kIndexedLeafCost + of_bytes(kIndexedLeafBytes)) : held;
  }
  bool indexes(float expected_area, std::size_t steps) const {
    return may_index &&
           expected_area * (kIndexedLeafCost - kLeafCost) <
               area_per_byte * (static_cast<float>(inline_leaf_bytes(steps)) - float{kIndexedLeafBytes});
  }
  float of_bytes(std::size_t bytes) const { return area_per_byte * static_cast<float>(bytes); }
};

/// A leaf against the parts of its time, two or more, each with a leaf of its own.
struct SplitCosts {
  float whole_area;  ///< expected
  float whole;
  float parts_area = 0.0f;
  float parts = 0.0f;
  std::size_t more_leaves = 1;

  void add_part(const BytePrice& price, float expected_area, std::size_t steps) {
    if (steps == 0) return;  // not alive then
    parts_area += expected_area;
    parts += price.of_leaf(expected_area, steps);
  }
  bool is_worth_it(const BytePrice& price) const {
    return parts_area < kLeastShrinking * whole_area &&
           parts + price.of_bytes(more_leaves * kNodeShareBytes) < whole;
  }
};

/// Where a mesh has more steps than this, the halves of a leaf's time may not be smaller though parts of
/// these are: what turns round and round, or goes to and fro, sweeps as much in half the time. Then a split
/// is looked at down to where it pays.
inline constexpr std::size_t kLongMotion = 17;

}  // namespace stbvh
