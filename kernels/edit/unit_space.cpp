#include "edit/unit_space.h"

#include <iterator>

namespace stbvh {

UnitSpace::Range UnitSpace::add(std::size_t first, std::size_t units) {
  unused_ += units;
  by_size_.emplace(units, first);
  return free_.emplace(first, units).first;
}

void UnitSpace::erase(Range range) {
  unused_ -= range->second;
  by_size_.erase({range->second, range->first});
  free_.erase(range);
}

std::optional<std::size_t> UnitSpace::take(std::size_t units) {
  const auto best = by_size_.lower_bound({units, 0});
  if (best == by_size_.end()) {
    if (units > capacity_ - end_) return std::nullopt;
    end_ += units;
    return end_ - units;
  }
  const auto [found, first] = *best;
  erase(free_.find(first));
  if (found > units) add(first + units, found - units);
  return first;
}

void UnitSpace::give_back(std::size_t first, std::size_t units) {
  const auto behind = free_.find(first + units);
  if (behind != free_.end()) {
    units += behind->second;
    erase(behind);
  }
  const auto next = free_.lower_bound(first);
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == first) {
      first = before->first;
      units += before->second;
      erase(before);
    }
  }
  if (first + units == end_) {
    end_ = first;
  } else {
    add(first, units);
  }
}

std::optional<std::size_t> UnitSpace::resized(std::size_t first, std::size_t units, std::size_t needed) {
  if (needed <= units) {
    if (needed < units) give_back(first + needed, units - needed);
    return first;
  }
  const std::optional<std::size_t> place = take(needed);
  if (place) give_back(first, units);
  return place;
}

}  // namespace stbvh
