/// Records back from their files.
#pragma once

#include <filesystem>
#include <string>

#include "harness/files/user_error.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// A file that is missing, broken, too large (64 MB) or too deep (100 levels), or not of records; what() is
/// one sentence for the user.
struct RecordFileError : UserError {
  using UserError::UserError;
};

struct ReadReport : Report {
  std::string machine;  ///< its type, in words: what machines have in common whose times may be compared
};

/// What speed against error is made of: the records of kind "speed" and "hard"; of speeds the fields that
/// Report names but hits and the spread of mrays_per_s. Throws RecordFileError.
ReadReport read_speeds_and_hards(const std::filesystem::path& path);

}  // namespace stbvh::harness
