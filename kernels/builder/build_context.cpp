#include "builder/build_context.h"

#include <algorithm>

namespace stbvh {

void BuildMemory::take(std::size_t bytes) {
  if (callbacks_.temporary_memory && !callbacks_.temporary_memory(static_cast<std::ptrdiff_t>(bytes))) {
    throw BuildCancelled();
  }
  const std::size_t now = current_.fetch_add(bytes) + bytes;
  std::size_t peak = peak_.load();
  while (peak < now && !peak_.compare_exchange_weak(peak, now)) {
  }
}

void BuildMemory::give_back(std::size_t bytes) noexcept {
  current_.fetch_sub(bytes);
  if (callbacks_.temporary_memory) callbacks_.temporary_memory(-static_cast<std::ptrdiff_t>(bytes));
}

void BuildProgress::add(double share) {
  if (!callbacks_.progress) return;
  check();
  done_.fetch_add(share);
  const std::unique_lock lock(report_, std::try_to_lock);
  if (!lock.owns_lock()) return;
  const double done = std::min(done_.load(), 1.0);  // read under the lock: what is reported never falls
  if (share > 0.0 && done < reported_ + 0.01) return;
  check();
  reported_ = done;
  report(done);
}

void BuildProgress::report(double fraction) {
  if (!callbacks_.progress || callbacks_.progress(fraction)) return;
  cancelled_.store(true);
  throw BuildCancelled();
}

}  // namespace stbvh
