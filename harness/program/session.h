/// What commands share that go from scene to scene: a scene in work, its rays, and what fits into memory.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "harness/program/options.h"
#include "harness/program/progress.h"
#include "harness/program/scene_source.h"
#include "harness/rays/ray_set.h"
#include "harness/report/records.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// The structure whose hit points bounce and shadow rays start from, whatever is compared; and the one that
/// stands in for it over scenes that Embree does not take.
inline constexpr std::string_view kReferenceStructure = "embree-robust";
inline constexpr std::string_view kOwnReferenceStructure = "stbvh-direct";

/// What such a command was asked for.
struct SessionOptions : SceneOptions, RecordOptions {};

/// The rays of `options` by `seed`, from hit points of the reference, which is built with `threads`.
std::vector<RaySet> make_ray_sets(const Scene& scene, const RayOptions& options, std::uint64_t seed,
                                  unsigned threads, Progress& progress);

/// Those of `names` that the machine's free memory can hold over `scene`, each beside the structure `beside`
/// (none if empty); for each other a line on stdout says how much it would need.
std::vector<std::string> structures_that_fit(const std::vector<std::string>& names, const Scene& scene,
                                             std::string_view beside);

/// As build_structure(); null where it cannot keep to the scene's limit of memory, which a line on stdout
/// says.
std::unique_ptr<StructureUnderTest> build_within_limit(const std::string& name, const Scene& scene,
                                                       unsigned threads);

/// Runs `work` on each scene of `options` in turn; before that a line on stdout says what the machine is.
/// Throws OutputFileError before all if an output file could not be written.
void for_each_scene(const SessionOptions& options, Progress& progress,
                    const std::function<void(const Scene&)>& work);

/// Throws OutputFileError if write_results could not write.
void check_outputs(const RecordOptions& options);

/// Prints a screen: `tables` where they are of one thing (`parts`), else `screen`. Writes `tables` and the
/// records of `report` to their files, if they were asked for. Throws OutputFileError.
void write_results(const RecordOptions& options, const Report& report, std::size_t parts,
                   const std::string& screen, const std::string& tables);

/// Writes `report` to the JSON file, if one was asked for. Throws OutputFileError.
void write_records(const RecordOptions& options, const Report& report);

}  // namespace stbvh::harness
