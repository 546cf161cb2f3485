#include "harness/cli/shot_frames.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "harness/program/usage_error.h"

namespace stbvh::harness {
namespace {

constexpr int kLargestNumber = 99'999'999;
constexpr std::size_t kMostFrames = 100'000;
constexpr double kMostRate = 1e6;
constexpr FilePart kHalfAFrame{.begin = -0.25, .end = 0.25};

/// "1001", "1001-1024" or "1001-1024:2"; false where it is none of these.
bool add_range(const std::string& text, std::set<int>& numbers) {
  int first = 0, last = 0, step = 1, end = 0;
  const int size = static_cast<int>(text.size());
  const auto is_read = [&](const char* format, auto*... parts) {
    end = 0;
    return std::sscanf(text.c_str(), format, parts..., &end) == static_cast<int>(sizeof...(parts)) &&
           end == size;
  };
  if (text.find_first_not_of("0123456789-:") != std::string::npos || size > 32) return false;
  if (is_read("%9d%n", &first)) {
    last = first;
  } else if (!is_read("%9d-%9d%n", &first, &last) && !is_read("%9d-%9d:%9d%n", &first, &last, &step)) {
    return false;
  }
  if (first > last || step < 1 || std::max(std::abs(first), std::abs(last)) > kLargestNumber) return false;
  for (int number = first; number <= last; number += step) {
    numbers.insert(number);
    if (numbers.size() > kMostFrames) throw UsageError(fmt::format("--frames: more than {}.", kMostFrames));
  }
  return true;
}

/// When the shutter of frame `number` is open, in frames.
FilePart part_of(const MakingOptions& making, int number) {
  FilePart part = making.gltf.shutter.value_or(kHalfAFrame);
  part.begin += number;
  part.end += number;
  return part;
}

/// What is loaded for the frames from `first` to `last`.
MakingOptions making_of(const FrameOptions& frames, MakingOptions making, int first, int last) {
  FilePart part{.begin = part_of(making, first).begin,
                .end = part_of(making, last).end,
                .is_in_frames = true,
                .frame_rate = frames.rate};
  if (!(part.begin < part.end)) part.end = part.begin + 1;  // a shutter that does not stay open
  making.gltf.shutter = part;
  return making;
}

/// A shutter in the time of the file as one in that of the rays.
Frame frame_of(const Take& take, const FilePart& part, int number, Shutter shutter) {
  const FilePart& loaded = *take.making.gltf.shutter;
  const auto ray_time = [&](double share) {
    const double time = part.begin + (part.end - part.begin) * share;
    return std::clamp((time - loaded.begin) / (loaded.end - loaded.begin), 0.0, 1.0);
  };
  shutter.open = ray_time(shutter.open);
  shutter.close = ray_time(shutter.close);
  return {number, shutter};
}

}  // namespace

std::vector<int> parse_frames(const std::string& text) {
  std::set<int> numbers;
  bool is_right = true;
  for (std::size_t begin = 0; is_right && begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    is_right = add_range(text.substr(begin, end - begin), numbers);
    begin = end + 1;
  }
  if (!is_right)
    throw UsageError(
        fmt::format("--frames takes numbers as in 1001-1024, 1001-1024:2 or 1,3,8-10, not \"{}\".", text));
  return {numbers.begin(), numbers.end()};
}

void add_frame_options(CLI::App& app, FrameOptions& frames) {
  CLI::Option* numbers = app.add_option_function<std::string>(
      "--frames", [&frames](const std::string& text) { frames.numbers = parse_frames(text); },
      "glTF, USD, Alembic: a picture of each of these frames, as in 1001-1024, 1001-1024:2 or 1,3,8-10; "
      "--shutter is then in frames, relative to each, and -0.25,0.25 by default");
  const auto take_rate = [&frames](double rate) {
    if (!(rate > 0 && rate <= kMostRate))
      throw UsageError(fmt::format("--fps must be above 0 and at most {}, not {}.", kMostRate, rate));
    frames.rate = rate;
  };
  app.add_option_function<double>("--fps", take_rate, "Frames in a second")
      ->default_str("those of a USD file, or 24")
      ->needs(numbers);
  app.add_flag(
         "--one-structure", frames.one_structure,
         "One structure over the time of all frames, instead of one each; glTF files are then read with "
         "--steps keys")
      ->needs(numbers);
}

std::vector<Take> takes_of(const FrameOptions& frames, const MakingOptions& making, const Shutter& shutter) {
  if (frames.numbers.empty()) return {{making, {{{}, shutter}}}};
  std::vector<Take> takes;
  const auto add_take = [&](int first, int last) -> Take& {
    return takes.emplace_back(Take{making_of(frames, making, first, last), {}});
  };
  if (frames.one_structure) {
    GltfOptions& gltf = add_take(frames.numbers.front(), frames.numbers.back()).making.gltf;
    gltf.at_keys = gltf.at_keys || !gltf.largest_deviation;
  }
  for (const int number : frames.numbers) {
    Take& take = frames.one_structure ? takes.front() : add_take(number, number);
    take.frames.push_back(frame_of(take, part_of(making, number), number, shutter));
  }
  return takes;
}

MakingOptions whole_file(MakingOptions making) {
  constexpr double kFewSteps = 0.1;
  making.gltf.shutter.reset();
  making.gltf.at_keys = true;
  making.gltf.largest_deviation = kFewSteps;
  making.resampling = {};
  making.tolerance = 0;
  making.max_bytes = {};
  making.warn = [](const std::string&) {};
  return making;
}

}  // namespace stbvh::harness
