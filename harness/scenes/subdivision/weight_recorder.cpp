#include "harness/scenes/subdivision/weight_recorder.h"

#include <cstdint>
#include <utility>

namespace stbvh::harness::subdivision {

WeightRecorder::WeightRecorder(std::vector<bool> is_used, std::size_t own)
    : is_used_(std::move(is_used)), own_(own) {}

WeightedSums WeightRecorder::take() {
  end_row(is_used_.size());
  sums_.own = own_;
  return std::move(sums_);
}

void WeightRecorder::add(std::size_t row, std::size_t column, double weight) {
  if (!is_used_[row] || weight == 0) return;
  sums_.columns.push_back(static_cast<std::uint32_t>(column));
  sums_.weights.push_back(weight);
}

void WeightRecorder::end_row(std::size_t next) {
  if (is_open_) sums_.first.push_back(sums_.columns.size());
  is_open_ = next < is_used_.size() && is_used_[next];
}

}  // namespace stbvh::harness::subdivision
