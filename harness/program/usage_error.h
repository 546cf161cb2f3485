/// What the user asked for cannot be done.
#pragma once

#include "harness/files/user_error.h"

namespace stbvh::harness {

/// what() is one sentence for the user; the program ends with exit code 2.
struct UsageError : UserError {
  using UserError::UserError;
};

}  // namespace stbvh::harness
