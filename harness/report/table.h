/// A report for a person to read.
#pragma once

#include <string>

#include "harness/report/machine.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// One line that says where and from what the figures come.
std::string machine_line(const Machine& machine, const std::string& commit);

std::string scene_heading(const SceneSummary& scene);

/// Builds of one scene: ratios to `embree` first where it is among them.
std::string build_table(const std::vector<BuildResult>& results);

/// Speeds in one scene, a column for each kind of rays.
std::string speed_table(const std::vector<SpeedResult>& results);

/// Errors in one scene, a line for each structure and kind of rays.
std::string error_table(const std::vector<ErrorResult>& results);

/// How far t is off, for the same lines: relative, in spacings of floats at t, and, of grazing hits, how far
/// from the plane.
std::string distance_table(const std::vector<ErrorResult>& results);

/// The rays of `results` that were answered otherwise than exactly, as far as they are kept: a line for each.
std::string difference_lines(const std::vector<ErrorResult>& results);

/// Names of the columns of hard_row.
std::string hard_heading();

/// One family and structure.
std::string hard_row(const HardResult& result);

/// What the columns are.
std::string hard_legend();

/// Speed and errors of each structure.
std::string pareto_table(const std::vector<ParetoResult>& points);

/// One line for each structure and value of a scaling run.
std::string scaling_table(const std::vector<ScalingResult>& results);

/// One structure over all frames against one for each.
std::string frames_table(const std::vector<FramesResult>& results);

/// Commits and speed of each structure by kind of edit.
std::string edits_table(const std::vector<EditResult>& results);

/// All scenes of a run: a block for each thread count, kind of rays and two references, then one for each
/// reference with bytes and build time. Empty if `results` is.
std::string summary_table(const std::vector<SummaryResult>& results);

/// A count of bad rays in `n`; none says what that proves: below 3/n with 95 % confidence.
std::string bad_count(std::size_t count, std::size_t n);

}  // namespace stbvh::harness
