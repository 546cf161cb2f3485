/// The commands of stbvh-ab.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <type_traits>

#include "harness/program/options.h"

namespace stbvh::harness {

/// Does what a command was asked for with the options that have been read from `command_line`.
using Work = std::function<void(const std::string& command_line)>;

/// The work of a command whose options, added to `app` by add_options(), are an `Options`.
template <class Options>
Work make_work(CLI::App& app, void (*run)(const Options&)) {
  const auto options = std::make_shared<Options>();
  add_options(app, *options);
  return [=](const std::string& command_line) {
    if constexpr (std::is_base_of_v<RecordOptions, Options>) options->command_line = command_line;
    run(*options);
  };
}

// Each adds its options to `app`, which must be there until they have been read.
Work bench_command(CLI::App& app);
/// Throws WrongAnswers, after the tables and the records, where a structure of ours was wrong.
Work error_command(CLI::App& app);
/// Throws WrongAnswers as `error` does.
Work hard_command(CLI::App& app);
/// Ends with a table and, if asked for, a plot of speed against error.
Work pareto_command(CLI::App& app);
/// Ends with a table of all structures and values.
Work scaling_command(CLI::App& app);
/// Throws WrongAnswers as `error` does, where an updated structure answers otherwise than one built anew.
Work edits_command(CLI::App& app);
Work frames_command(CLI::App& app);
/// Writes tables, records and pictures. Throws WrongAnswers as `error` does, ScriptFailure.
Work gallery_command(CLI::App& app);
/// Draws the records of bench, scaling, edits and frames; prints the files' names. Throws ScriptFailure.
Work charts_command(CLI::App& app);
/// Writes a page of the records of several machines. Throws ScriptFailure.
Work results_command(CLI::App& app);
/// Writes an OpenEXR file for each scene and structure. Throws Interrupted after the part that was finished
/// at SIGINT has been written.
Work render_command(CLI::App& app);
/// Prints how far a picture is from a reference; writes the difference picture and the record, if asked for.
Work compare_command(CLI::App& app);
/// Writes the picture that tiles of render are parts of. Throws UsageError where they are not, or not all of
/// it.
Work merge_command(CLI::App& app);
/// Prints how far renderings of motion are from the mean of renderings at frozen times; writes both pictures.
/// Throws Interrupted at SIGINT.
Work truth_command(CLI::App& app);
/// Runs the other commands for what is not there yet, then writes the page. Throws WrongAnswers after that
/// where a structure of ours was wrong, ScriptFailure where a command failed, which has said why.
Work report_command(CLI::App& app);
/// Writes a scene with its structure, for --scenes.
Work build_command(CLI::App& app);
/// Writes a scene as XML for Embree's own tools; prints the files' names.
Work convert_command(CLI::App& app);

/// The whole program: runs the command of a command line, prints one line on stderr for what cannot be done.
/// Returns the exit code: 0 done; 2 the user asked for what cannot be done; 1 it went wrong,
/// or error or hard found one of our structures to be wrong; 130 interrupted.
int run_program(int argc, const char* const* argv);

}  // namespace stbvh::harness
