/// A report as JSON: {"machine": ..., "commit": ..., "records": [...]}.
#pragma once

#include <filesystem>
#include <stdexcept>

#include "harness/report/machine.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// A report that could not be written; what() is one sentence for the user.
struct ReportFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Text of the whole report. Records come in the order build, speed, error.
std::string to_json(const Report& report, const Machine& machine, const std::string& commit);

/// Throws ReportFileError if write_file could not write to `path` as things stand. Leaves nothing behind.
void check_writable(const std::filesystem::path& path);

/// Writes `text` to `path`: under a temporary name beside it, then renamed, so that the file appears whole or
/// not at all. What is not a regular file (a device, a pipe) is written to directly. Throws ReportFileError.
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace stbvh::harness
