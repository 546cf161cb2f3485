#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "harness/cli/commands.h"
#include "harness/program/scene_options.h"
#include "harness/program/scene_source.h"
#include "harness/program/script.h"
#include "harness/program/usage_error.h"

namespace stbvh::harness {
namespace {

/// Rendered large, with many samples: how long a picture takes.
constexpr const char* kLargePicture = "barbarian";

struct ReportOptions : SceneOptions {
  std::vector<std::string> structures;  ///< empty: each command's own
  std::string output;                   ///< folder
  std::string from;                     ///< what need not be measured; empty: nothing
  bool quick = false;
  bool gallery = false;
  unsigned threads = 1;
};

void add_options(CLI::App& app, ReportOptions& o) {
  add_scene_options(app, o);
  add_structures_option(
      app, o.structures, {},
      "Names of structures (see list), or all; separated by commas. Pictures are made of each too")
      ->default_str("all but the fast and scalar ones; pictures of five");
  o.structures.clear();
  const auto take_output = [&o](const std::string& folder) {
    if (folder.empty()) throw UsageError("--output: a folder is needed.");
    o.output = folder;
  };
  app.add_option_function<std::string>("-o,--output", take_output,
                                       "Folder for the page; made if it is not there")
      ->required();
  app.add_option(
      "--from", o.from,
      "Folder of an earlier report, or of record files (bench.json, error.json, ...): its parts are "
      "not measured again");
  app.add_flag("--quick", o.quick, "Fewer rays, samples and frozen times");
  app.add_flag("--gallery", o.gallery, "The gallery too, which takes long");
  add_threads_option(app, o.threads);
}

void run_report(const ReportOptions& options) {
  find_scenes(options);  // refused before anything is measured
  std::vector<std::string> words{"--output=" + options.output,
                                 "--program=" + std::filesystem::read_symlink("/proc/self/exe").string(),
                                 fmt::format("--threads={}", options.threads)};
  if (!options.from.empty()) words.push_back("--from=" + options.from);
  if (!options.structures.empty())
    words.push_back(fmt::format("--structures={}", fmt::join(options.structures, ",")));
  if (options.quick) words.emplace_back("--quick");
  if (options.gallery) words.emplace_back("--gallery");
  if (std::find(options.scenes.begin(), options.scenes.end(), kLargePicture) != options.scenes.end())
    words.push_back(fmt::format("--large-picture={}", kLargePicture));
  words.emplace_back("--");
  words.insert(words.end(), options.scene_words.begin(), options.scene_words.end());
  run_script("report.py", words);
}

}  // namespace

Work report_command(CLI::App& app) {
  return make_work(app, run_report);
}

}  // namespace stbvh::harness
