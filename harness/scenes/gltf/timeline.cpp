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
  if (!options.shutter) return;
  const FilePart& shutter = *options.shutter;
  const double rate = shutter.frame_rate > 0 ? shutter.frame_rate : kFrameRate;
  begin_ = shutter.is_in_frames ? shutter.begin / rate : shutter.begin;
  end_ = shutter.is_in_frames ? shutter.end / rate : shutter.end;
  const bool needs_duration = options.at_keys || options.largest_deviation || options.steps > 1;
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

double Timeline::repeated(double time) const {
  if (!loops_ || (time >= clip_begin_ && time <= clip_end_)) return time;
  const double behind = std::fmod(time - clip_begin_, period());
  return clip_begin_ + (behind < 0 ? behind + period() : behind);
}

std::vector<Timeline::Moment> Timeline::moments(std::span<const Channel* const> channels) const {
  std::vector<Moment> moments;
  if (is_instant()) return moments;
  double first = 0, last = 0;  // repeats that the shutter reaches
  if (loops_) {
    first = std::floor((begin_ - clip_begin_) / period());
    last = std::floor((end_ - clip_begin_) / period());
  }
  const auto add = [&](double before, double after) {
    for (double repeat = first; repeat <= last; ++repeat) {
      const double fraction = (before + (loops_ ? repeat * period() : 0) - begin_) / (end_ - begin_);
      if (fraction >= 0 && fraction <= 1) moments.push_back({fraction, before, after});
    }
  };
  if (loops_) {
    --first;  // whose end may be the shutter's beginning
    add(clip_end_, clip_begin_);
  }
  for (const Channel* channel : channels) {
    for (std::size_t i = 0; i < channel->times.size(); ++i) {
      const double key = channel->times[i];
      const bool is_new = i == 0 || key != channel->times[i - 1];
      const bool is_at_repeat = loops_ && (key == clip_begin_ || key == clip_end_);
      if (is_new && !is_at_repeat) add(key, key);
    }
  }
  std::sort(moments.begin(), moments.end(),
            [](const Moment& a, const Moment& b) { return a.fraction < b.fraction; });
  return moments;
}

std::vector<double> Timeline::key_fractions(std::span<const Channel* const> channels) const {
  std::vector<double> fractions;
  for (const Moment& moment : moments(channels)) {
    const bool is_new = fractions.empty() || moment.fraction != fractions.back();
    if (is_new && moment.fraction > 0 && moment.fraction < 1) fractions.push_back(moment.fraction);
  }
  return fractions;
}

}  // namespace stbvh::harness::gltf
