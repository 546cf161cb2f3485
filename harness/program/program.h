/// How the programs of the harness begin, and how they end where something fails: with one line and an exit
/// code.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace stbvh::harness {

/// `text` with control characters, which names in files may hold, as question marks, and without its middle
/// where it is longer than a screen should hold.
std::string one_line(std::string text);

/// Writes `text` to stderr. One that cannot be written to is no reason to end: nothing is thrown.
void write_to_stderr(std::string_view text) noexcept;

/// Runs `work`, with an exit code. What it throws, it ends with one line on stderr: exit code 2 for what the
/// user asked for and cannot be had, 130 for an interruption, 1 for all else, such as too little memory or
/// a stdout to which not all could be written. ScriptFailure has an exit code of its own, and was told
/// already.
///
/// Too little memory ends the program the same way where no exception can be caught: before main(), in GMP
/// and in functions that must not throw.
int run_as_program(const std::function<void()>& work);

}  // namespace stbvh::harness
