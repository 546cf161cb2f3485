/// Where and from what source the figures come.
#pragma once

#include <string>

namespace stbvh::harness {

struct Machine {
  std::string cpu;
  unsigned cores = 0;  ///< that this process may use
  double memory_gb = 0;
  std::string instruction_set;  ///< of our own traversal
  std::string embree;           ///< version of the library in use
};

Machine this_machine();

/// Git commit that the program was built from, with "-dirty" where files differed from it; "unknown" without
/// git.
std::string built_commit();

}  // namespace stbvh::harness
