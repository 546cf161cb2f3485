/// What bench and error share: a scene in work, its rays, and what fits into memory.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "harness/cli/options.h"
#include "harness/cli/progress.h"
#include "harness/cli/scene_source.h"
#include "harness/rays/ray_set.h"
#include "harness/report/records.h"

namespace stbvh::harness {

/// The structure whose hit points bounce and shadow rays start from, whatever is compared.
inline constexpr std::string_view kReferenceStructure = "embree-robust";

/// `count` rays of each kind that was asked for, from kReferenceStructure's hit points.
std::vector<RaySet> make_ray_sets(const Scene& scene, const Options& options, Progress& progress);

/// Those of `names` that the machine's free memory can hold over `scene`, each beside the structure `beside`
/// (none if empty); for each other a line on stdout says how much it would need.
std::vector<std::string> structures_that_fit(const std::vector<std::string>& names, const Scene& scene,
                                             std::string_view beside);

/// Runs `work` on each scene of `options` in turn; before that a line on stdout says what the machine is.
/// Throws OutputFileError before all if an output file could not be written.
void for_each_scene(const Options& options, Progress& progress,
                    const std::function<void(const Scene&)>& work);

/// Throws OutputFileError if write_results could not write.
void check_outputs(const Options& options);

/// Prints a screen: `tables` where they are of one thing (`parts`), else `screen`. Writes `tables` and the
/// records of `report` to their files, if they were asked for. Throws OutputFileError.
void write_results(const Options& options, const Report& report, std::size_t parts, const std::string& screen,
                   const std::string& tables);

/// Writes `report` to the JSON file, if one was asked for. Throws OutputFileError.
void write_records(const Options& options, const Report& report);

}  // namespace stbvh::harness
