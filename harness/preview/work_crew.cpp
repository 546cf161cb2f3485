#include "harness/preview/work_crew.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>

namespace stbvh::harness {
namespace {

/// Items that a thread takes at once: taking one costs a lock.
constexpr std::size_t kItemsAtOnce = 4;

}  // namespace

void lower_priority(int niceness) {
  // Linux keeps it for each thread. Where it cannot be lowered, pictures only come less smoothly.
  static_cast<void>(setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), niceness));
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Where a thread cannot be started the destructor ends those before it: the constructor that it stands for is
// done.
WorkCrew::WorkCrew(std::size_t threads) : WorkCrew() {
  for (std::size_t i = 1; i < threads; ++i) helpers_.emplace_back([this] { help(); });
}

WorkCrew::~WorkCrew() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  begun_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void WorkCrew::run(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::unique_lock lock(mutex_);
  work_ = &work;
  next_ = 0;
  count_ = count;
  begun_.notify_all();
  take(lock);
  ended_.wait(lock, [this] { return busy_ == 0; });
  work_ = nullptr;
}

void WorkCrew::help() {
  lower_priority(kRendererNiceness);
  std::unique_lock lock(mutex_);
  for (;;) {
    begun_.wait(lock, [this] { return quit_ || next_ < count_; });
    if (quit_) return;
    take(lock);
  }
}

/// Works until nothing is left to be taken.
void WorkCrew::take(std::unique_lock<std::mutex>& lock) {
  ++busy_;
  while (next_ < count_) {
    const std::size_t first = next_, last = std::min(next_ + kItemsAtOnce, count_);
    next_ = last;
    const auto& work = *work_;
    lock.unlock();
    for (std::size_t i = first; i < last; ++i) work(i);
    lock.lock();
  }
  if (--busy_ == 0) ended_.notify_all();
}

}  // namespace stbvh::harness
