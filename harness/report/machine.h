/// Where and from what source the figures come.
#pragma once

#include <string>
#include <string_view>

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

/// What `program --version` prints: "stbvh-ab (STBVH for Embree) 0.1.0 (commit)".
std::string version_text(std::string_view program);

}  // namespace stbvh::harness
