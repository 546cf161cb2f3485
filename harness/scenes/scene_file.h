/// What all readers of scene files share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "harness/files/user_error.h"

namespace stbvh::harness {

/// A file that is missing, broken or needs what is not supported; what() is one sentence for the user.
struct SceneFileError : UserError {
  using UserError::UserError;
};

/// Part of the time of a file that has a clock.
struct FilePart {
  double begin = 0, end = 0;  ///< in seconds, or in frames
  bool is_in_frames = false;
  double frame_rate = 0;  ///< frames in a second; 0: those of the file, or kFrameRate
};

/// Whether a scene may have no mesh: a frame of a shot may be empty.
inline bool may_be_empty(const std::optional<FilePart>& part) {
  return part && part->is_in_frames;
}

/// Frames in a second where a file does not say.
inline constexpr double kFrameRate = 24;

/// In how many places a camera is kept that moves while the shutter is open: some for each frame.
inline std::size_t camera_step_count(const std::optional<FilePart>& shutter) {
  constexpr double kEachFrame = 32, kLeast = 129, kMost = 4096;
  const double frames = shutter && shutter->is_in_frames ? shutter->end - shutter->begin : 0;
  return static_cast<std::size_t>(std::clamp(std::ceil(kEachFrame * frames) + 1, kLeast, kMost));
}

/// Told a sentence for each thing that a scene is read without, or otherwise than the file means it.
using SceneWarning = std::function<void(const std::string& sentence)>;

/// Most bytes of vertex buffers that one file may grow to: what the largest machine of the measurements has.
inline constexpr std::size_t kMaxSceneFileBytes = std::size_t{24} << 30;

/// Most bytes of a scene file that is text, which is read whole.
inline constexpr std::size_t kMaxSceneTextBytes = std::size_t{4} << 30;

}  // namespace stbvh::harness
