#include "builder/build_memory.h"

namespace stbvh {

void BuildMemory::take(std::size_t bytes) {
  const std::size_t now = current_.fetch_add(bytes) + bytes;
  const bool fits = now <= limit_;
  if (!fits ||
      (callbacks_.temporary_memory && !callbacks_.temporary_memory(static_cast<std::ptrdiff_t>(bytes)))) {
    current_.fetch_sub(bytes);
    if (!fits) throw LimitReached();
    throw BuildCancelled();
  }
  std::size_t peak = peak_.load();
  while (peak < now && !peak_.compare_exchange_weak(peak, now)) {
  }
}

void BuildMemory::give_back(std::size_t bytes) noexcept {
  current_.fetch_sub(bytes);
  if (callbacks_.temporary_memory) callbacks_.temporary_memory(-static_cast<std::ptrdiff_t>(bytes));
}

}  // namespace stbvh
