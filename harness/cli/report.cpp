#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "harness/cli/commands.h"
#include "harness/cli/scene_source.h"
#include "harness/cli/script.h"

namespace stbvh::harness {
namespace {

/// Rendered large, with many samples: how long a picture takes.
constexpr const char* kLargePicture = "barbarian";

}  // namespace

void run_report(const Options& options) {
  find_scenes(options);  // refused before anything is measured
  std::vector<std::string> words{"--output=" + options.output.string(),
                                 "--program=" + std::filesystem::read_symlink("/proc/self/exe").string(),
                                 fmt::format("--threads={}", options.threads)};
  if (options.from) words.push_back("--from=" + options.from->string());
  if (!options.structures.empty())
    words.push_back(fmt::format("--structures={}", fmt::join(options.structures, ",")));
  if (options.quick) words.emplace_back("--quick");
  if (std::find(options.scenes.begin(), options.scenes.end(), kLargePicture) != options.scenes.end())
    words.push_back(fmt::format("--large-picture={}", kLargePicture));
  words.emplace_back("--");
  words.insert(words.end(), options.scene_words.begin(), options.scene_words.end());
  run_script("report.py", words);
}

}  // namespace stbvh::harness
