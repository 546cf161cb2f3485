#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>

#include "harness/cli/commands.h"
#include "harness/program/script.h"

namespace stbvh::harness {
namespace {

struct ChartOptions {
  std::vector<std::string> record_files;
  std::string directory;
  std::vector<std::string> structures;  ///< in the order in which they are drawn; empty: all
  std::string format = "svg";
};

void add_options(CLI::App& app, ChartOptions& o) {
  app.add_option("records", o.record_files, "Files that bench and scaling wrote with --json")->required();
  app.add_option("-o,--output", o.directory, "Directory for the charts")->required();
  app.add_option(
         "--structures", o.structures,
         "Names of structures in the records, separated by commas, in the order in which they are drawn")
      ->delimiter(',')
      ->default_str("all");
  app.add_option("--format", o.format, "svg or png")
      ->check(CLI::IsMember({"svg", "png"}))
      ->capture_default_str();
}

void run_charts(const ChartOptions& options) {
  std::vector<std::string> arguments{"--output=" + options.directory, "--format=" + options.format};
  if (!options.structures.empty())
    arguments.push_back(fmt::format("--structures={}", fmt::join(options.structures, ",")));
  arguments.emplace_back("--");
  arguments.insert(arguments.end(), options.record_files.begin(), options.record_files.end());
  run_script("charts.py", arguments);
}

struct ResultsOptions {
  std::vector<std::string> record_files;
  std::string output;
};

void add_options(CLI::App& app, ResultsOptions& o) {
  app.add_option("records", o.record_files, "Files that bench, error and hard wrote with --json")->required();
  app.add_option("-o,--output", o.output,
                 "Markdown file; where it has the markers of an earlier page, only what is between them is "
                 "replaced")
      ->required();
}

void run_results(const ResultsOptions& options) {
  std::vector<std::string> arguments{"--output=" + options.output, "--"};
  arguments.insert(arguments.end(), options.record_files.begin(), options.record_files.end());
  run_script("results.py", arguments);
}

}  // namespace

Work charts_command(CLI::App& app) {
  return make_work(app, run_charts);
}

Work results_command(CLI::App& app) {
  return make_work(app, run_results);
}

}  // namespace stbvh::harness
