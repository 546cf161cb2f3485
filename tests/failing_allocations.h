/// Memory that runs out, in programs that link failing_allocations.cpp.
#pragma once

namespace stbvh::test {

/// While it lives, operator new fails in this program and its libraries, Embree and TBB among them: in one
/// call (0: the first), or in that and all that follow. One at a time.
class FailingAllocations {
 public:
  enum class Which { kOne, kAllFrom };

  FailingAllocations(long number, Which which);
  ~FailingAllocations();
  FailingAllocations(const FailingAllocations&) = delete;
  FailingAllocations& operator=(const FailingAllocations&) = delete;

  /// Whether one has failed.
  bool have_failed() const;
};

/// While it lives, what the library with this function allocates itself does not fail. One at a time.
class SparedLibrary {
 public:
  explicit SparedLibrary(const void* function);
  ~SparedLibrary();
  SparedLibrary(const SparedLibrary&) = delete;
  SparedLibrary& operator=(const SparedLibrary&) = delete;
};

}  // namespace stbvh::test
