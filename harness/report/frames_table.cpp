#include <fmt/format.h>

#include <string>
#include <vector>

#include "harness/report/table.h"

namespace stbvh::harness {

std::string frames_table(const std::vector<FramesResult>& results) {
  std::string text =
      fmt::format("\n{:<16}{:>7}{:>11}{:>11}{:>10}{:>10}{:>9}{:>9}{:>16}{:>11}\n", "structure", "frames",
                  "all: s", "each: s", "all: MB", "each: MB", "all", "each", "crossover", "differ");
  for (const FramesResult& r : results) {
    const double crossover = r.crossover_rays();
    text += fmt::format("{:<16}{:>7}{:>11.3f}{:>11.3f}{:>10.1f}{:>10.1f}{:>9.2f}{:>9.2f}{:>16}{:>11}\n",
                        r.structure, r.frames, r.build_s, static_cast<double>(r.frames) * r.frame_build_s,
                        static_cast<double>(r.bytes) / 1e6, static_cast<double>(r.frame_bytes) / 1e6,
                        r.mrays_per_s, r.frame_mrays_per_s,
                        crossover < 0    ? "one is cheaper"
                        : crossover == 0 ? "each is cheaper"
                                         : fmt::format("{:.3g} rays", crossover),
                        fmt::format("{}/{}", r.differing, r.traced));
  }
  return text +
         "all: one structure over all frames; each: one for each frame, the seconds of all of them, the "
         "bytes of one; "
         "all, each: Mrays/s; crossover: rays of a frame from which on one for each is cheaper; differ: rays "
         "answered "
         "otherwise than by the other, beyond the rounding of their times.\n";
}

}  // namespace stbvh::harness
