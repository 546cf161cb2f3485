#include "harness/structures/build_meter.h"

#include <malloc.h>
#include <unistd.h>

#include <fstream>

namespace stbvh::harness {

std::size_t resident_bytes() {
  malloc_trim(0);
  std::size_t total_pages = 0;
  std::size_t resident_pages = 0;
  std::ifstream("/proc/self/statm") >> total_pages >> resident_pages;
  return resident_pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

BuildMeter::BuildMeter(unsigned threads) : resident_before_(resident_bytes()) {
  if (threads > 0) thread_limit_.emplace(tbb::global_control::max_allowed_parallelism, threads);
  start_ = std::chrono::steady_clock::now();
}

double BuildMeter::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::ptrdiff_t BuildMeter::resident_growth() const {
  return static_cast<std::ptrdiff_t>(resident_bytes()) - static_cast<std::ptrdiff_t>(resident_before_);
}

}  // namespace stbvh::harness
