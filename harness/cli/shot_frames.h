/// Frames of a shot: which are rendered, and what of the file's time each of them shows.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/path_tracer/lens_camera.h"
#include "harness/program/scene_options.h"

namespace stbvh::harness {

struct FrameOptions {
  std::vector<int> numbers;    ///< each once, in order; empty: one picture of the whole shutter
  double rate = 0;             ///< frames in a second; 0: those of the file, or kFrameRate
  bool one_structure = false;  ///< over all of them, or one each
};

/// --frames, --fps and --one-structure. Checks what is read: UsageError.
void add_frame_options(CLI::App& app, FrameOptions& frames);

/// The frames of "1001-1024", of "1001-1024:2" (every second one), of "-3--1", or of several of these with
/// commas between, as Open Job Description has them. Throws UsageError.
std::vector<int> parse_frames(const std::string& text);

/// A picture of a scene.
struct Frame {
  std::optional<int> number;  ///< none: it is the only one
  Shutter shutter;            ///< in the ray times of the scene
};

/// What is loaded at once, and what is rendered of it.
struct Take {
  MakingOptions making;
  std::vector<Frame> frames;
};

/// One for each frame, or one of them all. The part of the file's time that `making` has a shutter for is
/// relative to each frame, in frames; from half a frame around it without one. Within that the shutter opens
/// and closes as `shutter` says.
std::vector<Take> takes_of(const FrameOptions& frames, const MakingOptions& making, const Shutter& shutter);

/// All of the file, in few steps: what its framing camera sees.
MakingOptions whole_file(MakingOptions making);

}  // namespace stbvh::harness
