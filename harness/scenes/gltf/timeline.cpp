#include "harness/scenes/gltf/timeline.h"

#include <algorithm>
#include <cmath>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {

Timeline::Timeline(const Rig& rig, const Clip* clip, const GltfOptions& options) : rig_(&rig) {
  if (clip != nullptr) {
    begin_ = clip_begin_ = clip->begin;
    end_ = clip_end_ = clip->end;
    loops_ = options.shutter_mode == ShutterMode::kLoop && period() > 0;
  }
  if (!options.shutter_seconds) return;
  begin_ = static_cast<double>(options.shutter_seconds->begin);
  end_ = static_cast<double>(options.shutter_seconds->end);
  const bool needs_duration = options.largest_deviation || options.steps > 1;
  if (!std::isfinite(begin_) || !std::isfinite(end_) || (needs_duration && begin_ >= end_)) {
    fail("the shutter must open before it closes, but {} to {} seconds is asked for", begin_, end_);
  }
  if (loops_ && (end_ - begin_) / period() > kMaxSceneSteps) {
    fail("a shutter of {} seconds repeats a clip of {} seconds more than {} times", end_ - begin_, period(),
         kMaxSceneSteps);
  }
}

Timeline Timeline::part(const Rig& rig, double begin, double end) const {
  Timeline timeline = *this;
  timeline.rig_ = &rig;
  timeline.begin_ = begin_ + (end_ - begin_) * begin;
  if (end < 1) timeline.end_ = begin_ + (end_ - begin_) * end;
  return timeline;
}

double Timeline::clip_time(double time) const {
  if (!loops_ || (time >= clip_begin_ && time <= clip_end_)) return time;
  const double behind = std::fmod(time - clip_begin_, period());
  return clip_begin_ + (behind < 0 ? behind + period() : behind);
}

Pose Timeline::pose(double fraction) const {
  return rig_->pose(clip_time(begin_ + (end_ - begin_) * fraction));
}

std::vector<double> Timeline::key_fractions() const {
  std::vector<double> fractions;
  if (is_instant()) return fractions;
  double first = 0, last = 0;  // repeats that the shutter reaches
  if (loops_) {
    first = std::floor((begin_ - clip_begin_) / period());
    last = std::floor((end_ - clip_begin_) / period());
  }
  for (const Channel* channel : rig_->channels()) {
    for (const double key : channel->times) {
      for (double repeat = first; repeat <= last; ++repeat) {
        const double fraction = (key + (loops_ ? repeat * period() : 0) - begin_) / (end_ - begin_);
        if (fraction > 0 && fraction < 1) fractions.push_back(fraction);
      }
    }
  }
  std::sort(fractions.begin(), fractions.end());
  fractions.erase(std::unique(fractions.begin(), fractions.end()), fractions.end());
  return fractions;
}

}  // namespace stbvh::harness::gltf
