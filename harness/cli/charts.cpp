#include <fmt/format.h>

#include "harness/cli/commands.h"
#include "harness/cli/script.h"

namespace stbvh::harness {

void run_charts(const Options& options) {
  std::vector<std::string> arguments{"--output=" + options.directory.string(),
                                     "--format=" + options.chart_format};
  if (!options.structures.empty())
    arguments.push_back(fmt::format("--structures={}", fmt::join(options.structures, ",")));
  arguments.emplace_back("--");
  arguments.insert(arguments.end(), options.record_files.begin(), options.record_files.end());
  run_script("charts.py", arguments);
}

void run_results(const Options& options) {
  std::vector<std::string> arguments{"--output=" + options.output.string(), "--"};
  arguments.insert(arguments.end(), options.record_files.begin(), options.record_files.end());
  run_script("results.py", arguments);
}

}  // namespace stbvh::harness
