/// The progress of a build, and its cancellation.
#pragma once

#include <atomic>
#include <mutex>

#include "stbvh/structure.h"

namespace stbvh {

/// Adds up work done and tells the caller's callback, in steps of a percent.
class BuildProgress {
 public:
  explicit BuildProgress(const BuildCallbacks& callbacks) : callbacks_(callbacks) {}
  /// Tells the callback of 0 and of 1. Throw BuildCancelled if it returns false.
  void start() { report(0.0); }
  void finish() { report(1.0); }
  /// The work begins anew: the callback hears of it again where it was told of less.
  void restart() { done_ = 0.0; }
  /// `share` of the whole work, 0 to 1, is done; the callback is told in steps of a percent. Throws
  /// BuildCancelled once the callback has returned false.
  void add(double share);
  /// Tells the callback at once, whatever was done since it heard last. Throws BuildCancelled if it returns
  /// false.
  void poll() { add(0.0); }
  /// Throws BuildCancelled once a callback has returned false.
  void check() const {
    if (cancelled_.load(std::memory_order_relaxed)) throw BuildCancelled();
  }

 private:
  void report(double fraction);

  const BuildCallbacks& callbacks_;
  std::atomic<double> done_{0.0};
  std::atomic<bool> cancelled_{false};
  std::mutex report_;
  double reported_ = 0.0;
};

}  // namespace stbvh
