/// What all readers of scene files share.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "harness/files/user_error.h"

namespace stbvh::harness {

/// A file that is missing, broken or needs what is not supported; what() is one sentence for the user.
struct SceneFileError : UserError {
  using UserError::UserError;
};

/// Told a sentence for each thing that a scene is read without, or otherwise than the file means it.
using SceneWarning = std::function<void(const std::string& sentence)>;

/// Most bytes of vertex buffers that one file may grow to: what the largest machine of the measurements has.
inline constexpr std::size_t kMaxSceneFileBytes = std::size_t{24} << 30;

/// Most bytes of a scene file that is text, which is read whole.
inline constexpr std::size_t kMaxSceneTextBytes = std::size_t{4} << 30;

}  // namespace stbvh::harness
