/// What a run of the harness found, as it stands in tables and JSON.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "harness/images/compare.h"

namespace stbvh::harness {

/// Median, least and largest of some repeats.
struct Spread {
  double median = 0;
  double min = 0;
  double max = 0;
};

/// Of at least one value; the median of an even number is the mean of the two in the middle.
Spread spread_of(std::vector<double> values);

/// Of positive values; 0 if there are none.
double geometric_mean(const std::vector<double>& values);

/// The rate that `count` of `n` stay below with 95 % confidence (Poisson, Wilson and Hilferty's
/// approximation): 3 / n for none.
double rate_bound_95(std::size_t count, std::size_t n);

struct BuildResult {
  std::string scene;
  std::string structure;
  std::size_t triangles = 0;
  std::size_t primitive_segments = 0;
  unsigned threads = 0;
  std::size_t builds = 0;  ///< how many times it was built
  Spread build_s;
  std::size_t peak_bytes = 0;
  std::size_t structure_bytes = 0;
  std::size_t monitor_bytes = 0;      ///< as the structure's Embree device counts; 0 without one
  std::size_t total_bytes = 0;        ///< with the scene's vertex and index buffers
  std::ptrdiff_t resident_bytes = 0;  ///< growth of the process's resident memory
  std::size_t budget_bytes = 0;       ///< that structures that can were allowed; 0: as many as they like
  std::size_t wanted_bytes = 0;       ///< of the structure if it were not limited, about; 0: not known
  std::size_t steps = 0;              ///< of all meshes together, as they are given
  std::size_t steps_kept = 0;         ///< by the structure
  double tolerance = 0;               ///< that it was given, scene units
  double max_deviation = 0;           ///< of a vertex at any time for the steps left out
};

struct SpeedResult {
  std::string scene;
  std::string structure;
  std::string rays;
  std::size_t ray_count = 0;
  unsigned threads = 0;
  std::size_t repeats = 0;
  Spread mrays_per_s;
  std::vector<double> ratios_to_embree{};  ///< within each repeat; empty if embree did not fit
  std::size_t hits = 0;

  /// Of ratios_to_embree.
  std::optional<Spread> ratio_to_embree() const;
};

struct Percentiles {
  double p50 = 0;
  double p99 = 0;
  double max = 0;
};

/// Errors of the distance of closest hits (harness/oracle/judge.h); infinite where a hit at NaN or infinity
/// was reported.
struct DistanceFigures {
  Percentiles relative;
  Percentiles ulps;
  Percentiles off_plane;
  std::size_t grazing = 0;  ///< hits that off_plane is over
};

/// What was said to a ray.
struct RecordedAnswer {
  struct Hit {
    double t = 0;
    std::uint32_t mesh = 0;
    std::uint32_t primitive = 0;
    std::optional<std::uint32_t> face{};  ///< of the file; empty where it has no faces but its triangles
  };

  bool is_hit = false;
  std::optional<Hit> hit{};  ///< empty also for occlusion rays, of which no more is known
};

/// A ray that was answered otherwise than exactly, so that it can be traced again.
struct DifferingRay {
  std::size_t ray = 0;  ///< its index among those of its kind
  std::string verdict;
  std::array<float, 3> origin{};
  std::array<float, 3> direction{};
  float tnear = 0;
  float tfar = 0;
  float time = 0;
  RecordedAnswer reported{};
  RecordedAnswer exact{};
  double edge_distance_ulps = 0;
};

struct ErrorResult {
  std::string scene;
  std::string structure;
  std::string rays;
  std::size_t traced = 0;
  std::size_t oracle_hits = 0;
  std::size_t missed = 0;
  std::size_t false_hits = 0;
  std::size_t wrong_primitive = 0;
  std::size_t ties = 0;
  std::size_t within_rounding = 0;
  std::size_t near_edge = 0;
  DistanceFigures distance{};
  bool is_any_hit = false;                  ///< occlusion rays have no t and no primitive
  bool has_tolerance = false;               ///< surfaces of ours may stand elsewhere
  std::vector<DifferingRay> differences{};  ///< the first of them, without ties
};

/// What a structure answered to a family of hard cases.
struct HardResult {
  std::string family;
  std::string structure;
  std::size_t traced = 0;
  std::size_t oracle_hits = 0;
  std::optional<std::size_t> leaks{};  ///< of rays from inside a closed mesh; empty: there is none
  std::size_t missed = 0;
  std::size_t false_hits = 0;
  std::size_t wrong_primitive = 0;
  std::size_t near_misses = 0;                   ///< of within_rounding: exact hits that were missed
  std::size_t any_hit_wrong = 0;                 ///< the same rays asked for any hit: missed or false
  std::optional<std::size_t> self_hits{};        ///< of rays that leave from hit points; empty: none does
  std::optional<std::size_t> exact_self_hits{};  ///< what the exact answer has of them
  std::size_t ties = 0;
  std::size_t within_rounding = 0;
  std::size_t near_edge = 0;
  DistanceFigures distance{};
};

/// What is the same for a whole scene and heads its table.
struct SceneSummary {
  std::string name;
  std::size_t meshes = 0;
  std::size_t triangles = 0;
  std::size_t primitive_segments = 0;
  std::size_t buffer_bytes = 0;
};

/// A structure as a point of speed against error.
struct ParetoResult {
  std::string structure;
  Spread ratio_to_embree;  ///< geometric mean, least and largest over scenes and kinds of rays; 0: of none
  std::size_t aimed = 0;   ///< rays at vertices and edges of closed moving meshes, from inside
  std::size_t leaks = 0;
  std::size_t thin = 0;        ///< rays at needles and slivers
  std::size_t differing = 0;   ///< answered otherwise than exactly, within rounding or not
  double t_error_rel_p99 = 0;  ///< far from the origin
};

/// A structure at one point of a scaling run.
struct ScalingResult {
  std::string over;       ///< "steps", "triangles", "threads", "bytes" or "quarter turns"
  std::size_t value = 0;  ///< how many of them, as asked, percent of embree's bytes; what the scene has of
                          ///< triangles is in `build`
  BuildResult build;
  std::vector<SpeedResult> speeds{};  ///< of each kind of rays; none over triangles
};

/// What a structure of the gallery, or one that these are held against, is and does in a scene, beside its
/// build, its speeds and its errors.
struct GalleryResult {
  /// Of a mean ray.
  struct Visits {
    double nodes = 0;
    double leaves = 0;
    double triangle_tests = 0;
  };

  std::string scene;
  std::string structure;
  std::string compared_with;       ///< whose speed its own is held against: of the same instructions
  bool is_exact = false;           ///< promises exact answers
  std::string steps;               ///< that it takes, of any scene: "any", or how many at most
  std::string obstacle{};          ///< why it does not take this scene; empty: it does
  std::optional<Visits> visits{};  ///< bounce and uniform rays; empty: it does not count
  std::size_t traced = 0;          ///< of all kinds of rays
  std::size_t wrong = 0;           ///< answers beyond rounding
};

/// What a structure bounds parts of a scene with at a time, seen along z; or, of no structure, the triangles.
struct SliceResult {
  using Point = std::array<float, 2>;

  std::string scene;
  std::string structure;  ///< empty: the triangles
  double time = 0;
  std::vector<std::vector<Point>> shapes{};  ///< corners, in no order
};

/// A structure after an edit of its scene.
struct EditResult {
  std::string scene;
  std::string structure;      ///< that was updated; it is held against the same one built anew
  std::size_t edit = 0;       ///< the first is 1
  std::string what;           ///< kind of the edit
  std::size_t triangles = 0;  ///< of the scene
  double changed_share = 0;   ///< of them, of the meshes that were edited
  unsigned threads = 0;
  double commit_s = 0;
  double rebuild_s = 0;  ///< of the structure built anew; 0: it was not
  std::string rays{};    ///< kind; empty: none were traced
  std::size_t traced = 0;
  std::size_t differing = 0;      ///< answered otherwise by the structure built anew; ours alone
  std::optional<Spread> speed{};  ///< relative to the structure built anew
};

/// A structure over all frames of an animation against one for each.
struct FramesResult {
  std::string scene;
  std::string structure;
  std::size_t frames = 0;
  std::size_t triangles = 0;
  unsigned threads = 0;
  double build_s = 0;            ///< of the one over all frames
  std::size_t bytes = 0;         ///< likewise
  std::size_t buffer_bytes = 0;  ///< of all frames
  double frame_build_s = 0;      ///< of one for a frame
  std::size_t frame_bytes = 0;
  double mrays_per_s = 0;  ///< through the one over all frames, geometric mean over frames and kinds of rays
  double frame_mrays_per_s = 0;
  std::size_t traced = 0;
  std::size_t differing = 0;  ///< answered otherwise by the two

  /// Rays of a frame from which on a structure for each frame costs less time; negative: never, 0: always.
  double crossover_rays() const;
};

/// A structure against a reference over all scenes of a run that hold both.
struct SummaryResult {
  std::string structure;
  std::string reference;
  std::string measure;  ///< "speed", or the field of BuildResult: "structure_bytes", "total_bytes", "build_s"
  std::string rays;     ///< speed: the kind, or several joined by "+"; else empty
  unsigned threads = 0;  ///< that traced, or built
  std::size_t scenes = 0;
  Spread mean{};  ///< geometric mean of the ratios to the reference in each repeat; builds have one
  std::string worst_scene{};
  Spread worst{};  ///< its ratio in each repeat
};

/// A picture against a reference (harness/images/compare.h).
struct CompareResult {
  std::string picture;
  std::string reference;
  Comparison found;  ///< the map goes into no record
};

/// A picture of numbers for each pixel; its file in the folder of pictures.
struct HeatMapResult {
  std::string picture;
  double mean = 0;
  double largest = 0;
};

/// A rendering, and the pictures that show it; files in the folder of pictures.
struct RenderResult {
  std::string scene;
  std::string structure;
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t samples_per_pixel = 0;
  std::uint64_t seed = 0;
  double seconds = 0;
  double mrays_per_s = 0;
  std::string picture;
  std::string reference;           ///< the structure whose rendering `found` refers to; empty: this is it
  Comparison found{};              ///< the map goes into no record
  std::string difference_picture;  ///< empty where no pixel differs
  std::optional<HeatMapResult> nodes{};  ///< of camera rays; empty for structures that do not count
  std::optional<HeatMapResult> triangles{};
};

/// A rendering of motion against the mean of renderings at frozen times; files as of RenderResult.
struct TruthResult {
  std::string scene;
  std::string structure;
  std::string reference_structure;
  std::size_t frozen_times = 0;
  std::size_t samples_per_pixel = 0;
  Comparison found{};
  std::string picture;
  std::string reference_picture;
  std::string difference_picture;
};

struct Report {
  std::vector<BuildResult> builds;
  std::vector<SpeedResult> speeds;
  std::vector<ErrorResult> errors;
  std::vector<HardResult> hards;
  std::vector<ParetoResult> paretos;
  std::vector<SummaryResult> summaries;
  std::vector<ScalingResult> scalings;
  std::vector<GalleryResult> galleries;
  std::vector<SliceResult> slices;
  std::vector<EditResult> edits;
  std::vector<FramesResult> frames;
  std::vector<CompareResult> compares;
  std::vector<RenderResult> renders;
  std::vector<TruthResult> truths;
};

}  // namespace stbvh::harness
