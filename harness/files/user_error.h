/// What the user can change.
#pragma once

#include <stdexcept>

namespace stbvh::harness {

/// A file or an option that is wrong: what() is one sentence for the user; the program ends with exit code 2.
struct UserError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace stbvh::harness
