#include "harness/cli/shot_film.h"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <string>

#include "harness/files/input_file.h"
#include "harness/program/script.h"
#include "harness/program/unnamed_file.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t{4} << 30;

bool write_film(const std::vector<fs::path>& pictures, double rate, const fs::path& file) {
  UnnamedFile all, film;
  for (const fs::path& picture : pictures) all.append(read_whole_file(picture, kMostBytes));
  // Its colors have half the resolution: an even number of pixels.
  const std::optional<ScriptEnd> end = run_program({"ffmpeg",
                                                    "-nostdin",
                                                    "-loglevel",
                                                    "error",
                                                    "-y",
                                                    "-f",
                                                    "image2pipe",
                                                    "-framerate",
                                                    fmt::format("{}", rate),
                                                    "-c:v",
                                                    "png",
                                                    "-i",
                                                    all.path().string(),
                                                    "-vf",
                                                    "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                                    "-pix_fmt",
                                                    "yuv420p",
                                                    "-f",
                                                    "mp4",
                                                    film.path().string()});
  if (!end || end->exit_code == 127) return false;
  if (end->exit_code != 0 || end->signal != 0)
    throw std::runtime_error(fmt::format("\"{}\" was not made: ffmpeg failed.", file.string()));
  write_file(file, read_whole_file(film.path(), kMostBytes));
  return true;
}

}  // namespace stbvh::harness
