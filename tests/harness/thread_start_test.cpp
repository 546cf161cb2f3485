// A system that gives no more threads: an error, and the threads that were started end.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <system_error>

#include "harness/preview/preview_session.h"
#include "harness/preview/work_crew.h"
#include "harness/program/pinned_threads.h"

namespace {

std::atomic<int> threads_left{INT_MAX};

}  // namespace

/// Stands before the system's.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  if (threads_left.fetch_sub(1) <= 0) return EAGAIN;
  return create(thread, attributes, start, argument);
}

namespace stbvh::harness {
namespace {

/// Makes it with ever more threads to be had, until it can be made. Returns how often it could not.
template <typename Make>
int failures_of(const Make& make) {
  int failures = 0;
  for (;; ++failures) {
    threads_left = failures;
    try {
      make();
      threads_left = INT_MAX;
      return failures;
    } catch (const std::system_error& error) {
      threads_left = INT_MAX;
      EXPECT_EQ(error.code().value(), EAGAIN);
    }
  }
}

TEST(ThreadStart, OfPinnedThreads) {
  const unsigned count = usable_core_count();
  EXPECT_EQ(failures_of([=] { PinnedThreads threads(count); }), static_cast<int>(count));
}

TEST(ThreadStart, OfAWorkCrew) {
  EXPECT_EQ(failures_of([] { WorkCrew crew(4); }), 3);
}

TEST(ThreadStart, OfAPreview) {
  EXPECT_EQ(failures_of([] { PreviewSession session(3, 1); }), 4);  // two of the crew, renderer, loader
}

}  // namespace
}  // namespace stbvh::harness
