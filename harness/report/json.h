/// A report as JSON: {"machine": ..., "commit": ..., "command": ..., "records": [...]}.
#pragma once

#include <string>

#include "harness/report/machine.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// Text of the whole report. Records come in the order build, speed, error, hard, pareto, summary, scaling,
/// gallery, slice, edit, frames, compare, render, truth. `command`: the command line that made them; empty
/// where there is none.
std::string to_json(const Report& report, const Machine& machine, const std::string& commit,
                    const std::string& command = "");

}  // namespace stbvh::harness
