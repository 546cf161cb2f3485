#include "harness/cli/report_options.h"

#include <CLI/CLI.hpp>

#include "harness/cli/commands.h"
#include "harness/program/usage_error.h"

namespace stbvh::harness {

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
  const auto take_from = [&o](const std::string& folder) {
    if (!folder.empty()) o.from = folder;
  };
  app.add_option_function<std::string>(
      "--from", take_from,
      "Folder of an earlier report, or of record files (bench.json, error.json, ...): what is there "
      "is not measured again");
  app.add_flag("--quick", o.quick, "Fewer rays, samples and frozen times");
  add_threads_option(app, o.threads);
}

Work report_command(CLI::App& app) {
  return make_work(app, run_report);
}

}  // namespace stbvh::harness
