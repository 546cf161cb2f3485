// Preloaded, it makes the call of operator new fail whose number FAILING_ALLOCATION says (0: the first). A
// program that ends without it has exit code 77.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "tests/failing_allocations.h"

namespace {

class FromEnvironment {
 public:
  FromEnvironment() : failing_(number(), stbvh::test::FailingAllocations::Which::kOne) {}
  ~FromEnvironment() {
    if (failing_.have_failed()) return;
    std::fflush(nullptr);
    _exit(77);
  }

 private:
  static long number() {
    const char* const text = std::getenv("FAILING_ALLOCATION");
    return text == nullptr ? 0 : std::atol(text);
  }

  stbvh::test::FailingAllocations failing_;
};

const FromEnvironment kFromEnvironment;

}  // namespace
