#include "harness/cli/report_options.h"

#include <fmt/format.h>

#include "harness/cli/render_options.h"
#include "harness/cli/usage_error.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kMostFrozenTimes = 1'000'000;

}  // namespace

void add_report_options(CLI::App& command, Arguments& a) {
  command
      .add_option(
          "--structures", a.options.structures,
          "Names of structures (see list), or all; separated by commas. Pictures are made of each too")
      ->delimiter(',')
      ->default_str("all but the fast and scalar ones; pictures of five");
  command.add_option("-o,--output", a.output, "Folder for the page; made if it is not there")->required();
  command.add_option(
      "--from", a.from,
      "Folder of an earlier report, or of record files (bench.json, error.json, ...): its parts are not "
      "measured again");
  command.add_flag("--quick", a.options.quick, "Fewer rays, samples and frozen times");
  command.add_option("--threads", a.options.threads, "Threads")->default_str("all cores");
}

void add_truth_options(CLI::App& command, Arguments& a) {
  command.add_option("--structures", a.options.structures, "The structure that renders the motion")
      ->delimiter(',')
      ->default_str("stbvh");
  command
      .add_option("--frozen-times", a.options.frozen_times,
                  "Times whose renderings, one sample for each pixel, are combined to the reference")
      ->capture_default_str();
  command.add_option("--size", a.size, "WxH in pixels")->default_str("960x540");
  command
      .add_option("--spp", a.options.render.samples_per_pixel,
                  "Most samples for each pixel; from 1 on, times 4")
      ->capture_default_str();
  command.add_option("--threads", a.options.threads, "Threads")->default_str("all cores");
  command.add_option("-o,--output", a.output, "Folder for the pictures; made if it is not there")->required();
  command.add_option("--json", a.json, "File for the records");
}

void check_report_options(Arguments& a) {
  a.options.output = a.output;
  if (a.options.output.empty()) throw UsageError("--output: a folder is needed.");
  if (!a.from.empty()) a.options.from = a.from;
}

void check_truth_options(Arguments& a, const CLI::App& command) {
  a.options.output = a.output;
  if (command.count("--scenes") == 0) a.options.scenes = {"wheels"};
  if (a.options.scenes.size() != 1) throw UsageError("--scenes: one scene.");
  if (command.count("--size") > 0) check_size(a);
  check_samples(a);
  if (a.options.frozen_times < 1 || a.options.frozen_times > kMostFrozenTimes) {
    throw UsageError(
        fmt::format("--frozen-times must be 1 to {}, not {}.", kMostFrozenTimes, a.options.frozen_times));
  }
}

}  // namespace stbvh::harness
