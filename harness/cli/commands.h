/// What stbvh-ab does.
#pragma once

#include "harness/cli/options.h"

namespace stbvh::harness {

void run_list();
void run_bench(const Options& options);
/// Throws WrongAnswers, after the tables and the records, where a structure of ours was wrong.
void run_error(const Options& options);
/// Throws WrongAnswers as run_error does.
void run_hard(const Options& options);
/// Ends with a table and, if asked for, a plot of speed against error.
void run_pareto(const Options& options);
/// Ends with a table of all structures and values.
void run_scaling(const Options& options);
/// Draws the records of bench and scaling; prints the files' names. Throws ScriptFailure.
void run_charts(const Options& options);
/// Writes a page of the records of several machines. Throws ScriptFailure.
void run_results(const Options& options);
/// Writes an OpenEXR file for each scene and structure. Throws Interrupted after the part that was finished
/// at SIGINT has been written.
void run_render(const Options& options);
/// Prints how far a picture is from a reference; writes the difference picture and the record, if asked for.
void run_compare(const Options& options);
/// Prints how far renderings of motion are from the mean of renderings at frozen times; writes both pictures.
/// Throws Interrupted at SIGINT.
void run_truth(const Options& options);
/// Runs the other commands for what is not there yet, then writes the page. Throws WrongAnswers after that
/// where a structure of ours was wrong, ScriptFailure where a command failed, which has said why.
void run_report(const Options& options);
/// Writes a scene as XML for Embree's own tools; prints the files' names.
void run_convert(const Options& options);

/// The whole program: runs the command of a command line, prints one line on stderr for what cannot be done.
/// Returns the exit code: 0 done; 2 the user asked for what cannot be done; 1 it went wrong,
/// or error or hard found one of our structures to be wrong; 130 interrupted.
int run_program(int argc, const char* const* argv);

}  // namespace stbvh::harness
