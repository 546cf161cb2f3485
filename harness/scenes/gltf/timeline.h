/// The state of a glTF file, or of what one of its meshes follows, at any moment of a shutter.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/gltf.h"
#include "harness/scenes/gltf/pose.h"

namespace stbvh::harness::gltf {

class Timeline {
 public:
  /// Keeps a reference to `rig`. Throws Problem for shutters that do not open, and for those that repeat a
  /// clip more than kMaxSceneSteps times.
  Timeline(const Rig& rig, const Clip* clip, const GltfOptions& options);

  /// The same of another rig, during [begin, end] of it.
  Timeline part(const Rig& rig, double begin = 0, double end = 1) const;

  /// Whether it has no duration: everything stands still.
  bool is_instant() const { return !(begin_ < end_); }
  const Rig& rig() const { return *rig_; }
  /// At 0, when the shutter opens, to 1, when it closes.
  Pose pose(double fraction, Scaling scaling = Scaling::kAsInFile) const {
    return rig_->pose(clip_time(fraction), Side::kAfter, scaling);
  }
  /// Seconds of the clip, likewise.
  double clip_time(double fraction) const { return repeated(begin_ + (end_ - begin_) * fraction); }

  /// When a channel of the rig has a key or the clip begins again.
  struct Moment {
    double fraction;       ///< of the shutter
    double before, after;  ///< seconds of the clip
  };
  /// Those in [0, 1], ascending.
  std::vector<Moment> moments() const { return moments(rig_->channels()); }
  /// Of some channels only.
  std::vector<Moment> moments(std::span<const Channel* const> channels) const;
  /// Their fractions inside (0, 1), each once.
  std::vector<double> key_fractions() const { return key_fractions(rig_->channels()); }
  std::vector<double> key_fractions(std::span<const Channel* const> channels) const;

 private:
  double repeated(double time) const;
  double period() const { return clip_end_ - clip_begin_; }

  const Rig* rig_;
  double clip_begin_ = 0, clip_end_ = 0;  // seconds
  double begin_ = 0, end_ = 0;            // likewise
  bool loops_ = false;
};

}  // namespace stbvh::harness::gltf
