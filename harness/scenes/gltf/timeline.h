/// The state of a glTF file at any moment of a shutter.
#pragma once

#include <tiny_gltf.h>

#include <optional>
#include <vector>

#include "harness/scenes/gltf/clip.h"
#include "harness/scenes/gltf/gltf.h"
#include "harness/scenes/gltf/pose.h"

namespace stbvh::harness::gltf {

class Timeline {
 public:
  /// Keeps references to `model`, `tree` and `clip`. Throws Problem for shutters that do not open, and for
  /// those that repeat a clip more than kMaxSteps times.
  Timeline(const tinygltf::Model& model, const NodeTree& tree, const std::optional<Clip>& clip,
           const GltfOptions& options);

  /// Whether it has no duration: everything stands still.
  bool is_instant() const { return !(begin_ < end_); }
  /// At 0, when the shutter opens, to 1, when it closes.
  Pose pose(double fraction) const;
  /// Fractions inside (0, 1) at which a channel has a key or a clip begins again; ascending, each once.
  std::vector<double> key_fractions() const;

 private:
  double clip_time(double time) const;
  double period() const { return clip_->end - clip_->begin; }

  const tinygltf::Model& model_;
  const NodeTree& tree_;
  const Clip* clip_;
  double begin_ = 0, end_ = 0;  // seconds
  bool loops_ = false;
};

}  // namespace stbvh::harness::gltf
