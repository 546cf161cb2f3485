/// How deep the text of a USD file is nested.
#pragma once

#include "harness/files/input_file.h"

namespace stbvh::harness {

/// More than any file needs: usd-core takes a time that grows with the square of it, and far deeper text
/// crashes it.
inline constexpr int kMaxUsdDepth = 200;

/// Whether a file that is USD in text (any other is not) has more brackets inside each other, outside of
/// strings, comments and names of files. Throws InputFileError.
bool is_nested_too_deeply(const InputFile& file);

}  // namespace stbvh::harness
