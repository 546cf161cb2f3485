/// How smoothly a window is drawn.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace stbvh::harness {

/// Times from the end of each frame to the end of the next, of frames that follow each other without waiting
/// for something to show.
class FrameTimes {
 public:
  void add(double seconds) {
    all_.push_back(seconds);
    recent_ = recent_ == 0 ? seconds : 0.9 * recent_ + 0.1 * seconds;
  }
  std::size_t count() const { return all_.size(); }
  /// Of the last frames; 0 before the first.
  double per_second() const { return recent_ > 0 ? 1 / recent_ : 0; }
  double mean() const {
    double sum = 0;
    for (double s : all_) sum += s;
    return all_.empty() ? 0 : sum / static_cast<double>(all_.size());
  }
  /// Time that the share `p` of all frames stayed below.
  double quantile(double p) const {
    if (all_.empty()) return 0;
    std::vector<double> sorted = all_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(p * static_cast<double>(sorted.size() - 1))];
  }

 private:
  std::vector<double> all_;
  double recent_ = 0;
};

}  // namespace stbvh::harness
