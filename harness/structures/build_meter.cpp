#include "harness/structures/build_meter.h"

#include <malloc.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "harness/files/input_file.h"

namespace stbvh::harness {

std::size_t resident_bytes() {
  malloc_trim(0);
  const std::string pages = read_proc_file("/proc/self/statm");  // the second number: those in memory
  const std::size_t resident = std::strtoul(pages.c_str() + pages.find(' ') + 1, nullptr, 10);
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
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
