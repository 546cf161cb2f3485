#include "harness/program/pinned_threads.h"

#include <pthread.h>
#include <sched.h>
#include <xmmintrin.h>

#include <algorithm>

namespace stbvh::harness {
namespace {

std::vector<int> usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof(set), &set);
  std::vector<int> cores;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(static_cast<std::size_t>(core), &set)) cores.push_back(core);
  }
  return cores;
}

void pin_to(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(core), &set);
  pthread_setaffinity_np(pthread_self(), sizeof(set), &set);
}

constexpr unsigned kFlushDenormals = 0x8040;  // flush to zero, and denormals are zero

}  // namespace

unsigned usable_core_count() {
  return static_cast<unsigned>(usable_cores().size());
}

PinnedThreads::PinnedThreads(unsigned count, NotStarted)
    : start_(count + 1), finish_(count + 1), times_(count) {}

// Where a thread cannot be started the destructor ends those before it: the constructor that it stands for is
// done.
PinnedThreads::PinnedThreads(unsigned count) : PinnedThreads(count, NotStarted{}) {
  const std::vector<int> cores = usable_cores();
  for (unsigned i = 0; i < count; ++i) {
    threads_.emplace_back([this, i, core = cores.at(i)] { serve(i, core); });
  }
}

PinnedThreads::~PinnedThreads() {
  work_ = nullptr;
  const std::size_t not_started = times_.size() - threads_.size();
  static_cast<void>(start_.arrive(static_cast<std::ptrdiff_t>(not_started + 1)));
  for (std::thread& thread : threads_) thread.join();
}

double PinnedThreads::run(const std::function<void(unsigned)>& work) {
  work_ = &work;
  start_.arrive_and_wait();
  finish_.arrive_and_wait();
  Times all = times_.front();
  for (const Times& t : times_) {
    all.begin = std::min(all.begin, t.begin);
    all.end = std::max(all.end, t.end);
  }
  return std::chrono::duration<double>(all.end - all.begin).count();
}

void PinnedThreads::serve(unsigned thread, int core) {
  pin_to(core);
  _mm_setcsr(_mm_getcsr() | kFlushDenormals);
  for (;;) {
    start_.arrive_and_wait();
    if (work_ == nullptr) return;
    times_[thread].begin = Clock::now();
    (*work_)(thread);
    times_[thread].end = Clock::now();
    finish_.arrive_and_wait();
  }
}

}  // namespace stbvh::harness
