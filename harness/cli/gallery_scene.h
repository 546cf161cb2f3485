/// The structures of the gallery over one scene: their answers held against the oracle before they are
/// timed, and what rays meet in them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "harness/cli/judged_rays.h"
#include "harness/cli/scene_bench.h"
#include "harness/program/pinned_threads.h"
#include "harness/program/progress.h"
#include "harness/report/records.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// Those that methods are held against: the first one with vector instructions, the second one without.
inline constexpr std::string_view kGalleryReferences[]{"stbvh-direct", "stbvh-direct-scalar"};

/// That which the speed of `structure` is held against.
std::string_view compared_with(std::string_view structure);

/// The steps that a structure takes, of any scene: "any", or how many a mesh may have at most, with "even"
/// where their times must be.
std::string steps_taken(std::string_view structure);

class GalleryScene {
 public:
  GalleryScene(const Scene& scene, PinnedThreads& threads, Progress& progress)
      : scene_(scene), threads_(threads), progress_(progress) {}

  /// As OnBuilt. Says so on stdout where a structure is wrong that promised not to be.
  void on_built(const std::string& name, const StructureUnderTest& structure, std::span<const RaySet> sets);

  /// Of those of `names` that were built, and why the others were not.
  std::vector<GalleryResult> results(const std::vector<std::string>& names) const;
  const std::vector<ErrorResult>& errors() const { return errors_; }

 private:
  void warn(const GalleryResult& result);

  const Scene& scene_;
  PinnedThreads& threads_;
  Progress& progress_;
  std::optional<JudgedRays> judged_;
  std::vector<GalleryResult> results_;
  std::vector<ErrorResult> errors_;
};

}  // namespace stbvh::harness
