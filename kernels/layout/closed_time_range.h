/// The times of a subtree.
#pragma once

namespace stbvh {

/// Closed range of float times; the next range begins at the next float.
struct ClosedTimeRange {
  float begin;
  float last;

  float length() const { return last - begin; }
  bool operator==(const ClosedTimeRange&) const = default;
};

}  // namespace stbvh
