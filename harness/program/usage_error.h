/// What the user asked for cannot be done.
#pragma once

#include <stdexcept>

namespace stbvh::harness {

/// what() is one sentence for the user; the program ends with exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace stbvh::harness
