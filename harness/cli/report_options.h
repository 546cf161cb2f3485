/// The options of `report` and `truth` beside those of their scenes.
#pragma once

#include <CLI/CLI.hpp>

#include "harness/cli/check_options.h"

namespace stbvh::harness {

void add_report_options(CLI::App& command, Arguments& arguments);
void add_truth_options(CLI::App& command, Arguments& arguments);

/// Throw UsageError.
void check_report_options(Arguments& arguments);
void check_truth_options(Arguments& arguments, const CLI::App& command);

}  // namespace stbvh::harness
