/// The methods that came before the STBVH, and ours with its ideas taken away one by one: each a structure
/// that runs, made of the same parts (docs/gallery.md).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "harness/structures/structure_under_test.h"

namespace stbvh::harness::gallery {

using StructurePtr = std::unique_ptr<StructureUnderTest>;

struct GalleryEntry {
  std::string_view name;
  std::string_view description;  ///< one line
  StructurePtr (*build)(const Scene& scene, unsigned threads, const BuildProgress& progress);
  std::string (*obstacle)(const Scene& scene) = nullptr;  ///< as obstacle(); null: there is none
  bool is_exact = true;    ///< false: it answers for other times than the rays'
  bool is_scalar = false;  ///< to be held against `stbvh-direct-scalar`
};

/// In the order in which tables print them: by the year of the method, then ours.
std::span<const GalleryEntry> gallery_entries();

StructurePtr build_kd4(const Scene& scene, unsigned threads, const BuildProgress& progress);
template <std::size_t kWindows>
StructurePtr build_separate(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_time_boxes(const Scene& scene, unsigned threads, const BuildProgress& progress);
std::string time_boxes_obstacle(const Scene& scene);
StructurePtr build_union(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_box_sequence(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_box_sequence_tsah(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_msbvh(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_slabs_12(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_obb_linear(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_linear(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_stbvh_paper(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_stbvh_gated(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_no_leaf_cost(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_no_temporal_first(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_no_tight_lines(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_no_static_side(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_no_optimal_collapse(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_no_meshlets(const Scene& scene, unsigned threads, const BuildProgress& progress);
StructurePtr build_no_step_reduction(const Scene& scene, unsigned threads, const BuildProgress& progress);

}  // namespace stbvh::harness::gallery
