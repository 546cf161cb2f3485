/// Which times the shutter is open: at a moment, over a range, frame after frame.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "harness/path_tracer/lens_camera.h"

namespace stbvh::harness {

/// The scene's time [0, 1] as frames of a film. All are seen through the same structure: it holds for all
/// times, so nothing is built again from frame to frame.
class Animation {
 public:
  std::size_t frames = 24;
  double seconds = 4;          ///< that all frames take
  double shutter_share = 0.5;  ///< of a frame, that the shutter is open
  bool is_frozen = false;      ///< it opens for a moment
  bool is_whole = true;        ///< it is open all the time, instead
  bool is_playing = false;

  double time() const { return time_; }
  /// Held within [0, 1].
  void scrub(double time) { time_ = std::clamp(time, 0.0, 1.0); }

  std::size_t frame() const {
    return std::min(static_cast<std::size_t>(time_ * static_cast<double>(frames)), frames - 1);
  }

  /// Goes on by `elapsed` seconds, from the last frame to the first. True where another frame has begun.
  bool advance(double elapsed) {
    if (!is_playing) return false;
    const std::size_t before = frame();
    time_ = std::fmod(time_ + elapsed / seconds, 1.0);
    return frame() != before;
  }

  Shutter shutter() const {
    if (is_playing) {
      const auto n = static_cast<double>(frames), open = static_cast<double>(frame()) / n;
      return {.open = open, .close = is_frozen ? open : std::min(1.0, open + shutter_share / n)};
    }
    if (is_frozen) return {.open = time_, .close = time_};
    if (is_whole) return {};
    return {.open = time_, .close = std::min(1.0, time_ + shutter_share / static_cast<double>(frames))};
  }

 private:
  double time_ = 0.5;
};

}  // namespace stbvh::harness
