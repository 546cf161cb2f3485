/// Which units of a structure's block are in use: room for what a change adds.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace stbvh {

/// Hands out ranges of units: first what was given back, then what lies behind everything.
class UnitSpace {
 public:
  UnitSpace() = default;
  UnitSpace(std::size_t used, std::size_t capacity) : end_(used), capacity_(capacity) {}

  /// The first of `units` units next to each other; none where the block must grow for that.
  std::optional<std::size_t> take(std::size_t units);
  void give_back(std::size_t first, std::size_t units);
  /// Where `units` from `first` on go on as `needed`: there, or elsewhere if these are more. What is not
  /// needed is given back; none as of take(), then they stay.
  std::optional<std::size_t> resized(std::size_t first, std::size_t units, std::size_t needed);

  /// Behind which nothing is in use.
  std::size_t end() const { return end_; }
  std::size_t capacity() const { return capacity_; }
  void grow_to(std::size_t capacity) { capacity_ = capacity; }
  /// Before end().
  std::size_t unused() const { return unused_; }

 private:
  using Range = std::map<std::size_t, std::size_t>::iterator;
  Range add(std::size_t first, std::size_t units);
  void erase(Range range);

  std::map<std::size_t, std::size_t> free_;                ///< first -> units, never side by side
  std::set<std::pair<std::size_t, std::size_t>> by_size_;  ///< the same, (units, first)
  std::size_t end_ = 0;
  std::size_t capacity_ = 0;
  std::size_t unused_ = 0;
};

}  // namespace stbvh
