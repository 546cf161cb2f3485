/// How the fuzz targets report a violated invariant.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace stbvh::fuzz {

/// Aborts, which the fuzzer takes for a finding, unless `condition` holds.
inline void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "violated: %s\n", what);
  std::abort();
}

}  // namespace stbvh::fuzz
