// Tasks that write to the same number, which the thread sanitizer must find, and others that are ordered by
// TBB, of which it must say nothing: that tbb_order.cpp and tsan.supp neither hide too much nor too little.
// Usage: race_in_tasks [race]
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <thread>
#include <vector>

namespace {

constexpr std::size_t kCount = 200;

/// Long enough that several threads take part.
void linger() {
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

std::size_t ordered() {
  std::vector<std::size_t> in(kCount), out(kCount);
  std::size_t sum = 0;
  for (std::size_t round = 0; round < 3; ++round) {
    for (std::size_t& x : in) x = round;
    tbb::parallel_for(std::size_t{0}, kCount, [&](std::size_t i) {
      out[i] = in[i];
      linger();
    });
    tbb::task_group group;
    group.run([&] { in[0] = out[0]; });
    group.run([&] { in[1] = out[1]; });
    group.wait();
    for (std::size_t i = 0; i < kCount; ++i) sum += in[i] + out[i];
  }
  try {
    tbb::parallel_for(std::size_t{0}, kCount, [&](std::size_t i) {
      out[i] = i;
      linger();
      if (i % 8 == 7) throw std::runtime_error("Enough.");
    });
  } catch (const std::runtime_error&) {
    for (std::size_t x : out) sum += x;
  }
  return sum;
}

std::size_t racing() {
  std::size_t sum = 0;
  tbb::parallel_for(std::size_t{0}, kCount, [&](std::size_t i) {
    sum += i;
    linger();
  });
  return sum;
}

}  // namespace

int main(int argc, char**) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 4);
  std::printf("%zu\n", argc > 1 ? racing() : ordered());
  return 0;
}
