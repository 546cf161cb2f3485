// The floor of the traversal: what single steps and small queries cost with everything in the caches, how
// much of a ray in a large scene is waiting, and how much the motion costs it.
#include <xmmintrin.h>

#include "harness/microbenchmarks/benchmarks.h"

int main(int argc, char** argv) {
  using namespace stbvh::harness;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  register_steps();
  register_whole_queries();
  register_embree_calls();
  register_waiting();
  register_frozen();
  constexpr unsigned kFlushDenormals = 0x8040;  // as Embree asks of applications
  _mm_setcsr(_mm_getcsr() | kFlushDenormals);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return any_wrong_answer() ? 1 : 0;
}
