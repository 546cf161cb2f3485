/// The truth: each ray against all triangles of a scene, in exact arithmetic where double precision cannot
/// tell.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "harness/oracle/mesh_cull.h"
#include "harness/oracle/ray_triangle.h"
#include "harness/scenes/scene.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

struct OraclePrimitive {
  std::uint32_t geom_id = kInvalidId;
  std::uint32_t prim_id = kInvalidId;

  auto operator<=>(const OraclePrimitive&) const = default;
};

struct OracleAnswer {
  bool is_hit = false;  ///< the exact answer: some triangle is hit at tnear < t <= tfar
  /// All triangles that are hit at the least t there is, ascending; empty for a miss.
  std::vector<OraclePrimitive> nearest;
  std::uint32_t geom_id = kInvalidId;  ///< of the first of them, as are the following
  std::uint32_t prim_id = kInvalidId;
  double t = 0, u = 0, v = 0;       ///< the doubles nearest to the exact values; Embree's barycentrics
  double t_lower = 0, t_upper = 0;  ///< what t can become within rounding
  double cosine = 0;                ///< between the ray and that triangle's normal, absolute

  std::uint32_t ties = 0;    ///< other hits whose t is the same within rounding
  bool is_possible = false;  ///< some movement within rounding hits something
  /// The nearest hit that stays one however things move is not farther than this; infinite: there is none.
  double certain_t_upper = std::numeric_limits<double>::infinity();
  /// The exact answer may change within rounding: a triangle that is possible but not certain lies before the
  /// nearest certain hit.
  bool is_near_edge = false;
  /// Units in the last place that ray, time and vertices must move by before a triangle that matters is hit
  /// or missed otherwise: the nearest hit's, or one passed within rounding before it. Infinite for a ray near
  /// nothing.
  double edge_distance_ulps = std::numeric_limits<double>::infinity();

  /// Triangles for which double precision could not tell whether, or before which other, they are hit.
  std::uint32_t exact_triangles = 0;

  /// Whether that triangle is one of the nearest.
  bool meets(OraclePrimitive primitive) const {
    return std::binary_search(nearest.begin(), nearest.end(), primitive);
  }

  bool is_certain() const { return certain_t_upper < std::numeric_limits<double>::infinity(); }
};

/// Triangle `prim_id` of mesh `geom_id` against `ray`; empty where that triangle does not exist, is invalid,
/// or cannot be hit by the ray because of its time or mask, or because the ray hits nothing at all.
std::optional<TriangleTest> test_primitive(const Scene& scene, const Ray& ray, std::uint32_t geom_id,
                                           std::uint32_t prim_id);

/// Answers rays over a scene that outlives it; built once, asked from any number of threads.
class Oracle {
 public:
  enum class Cull { kBoxes, kNone };

  /// Cull::kNone tests every triangle for every ray: what the answers with boxes are certified against.
  explicit Oracle(const Scene& scene, Cull cull = Cull::kBoxes);

  OracleAnswer answer(const Ray& ray) const;

  /// answer() for all rays, in parallel.
  std::vector<OracleAnswer> answers(std::span<const Ray> rays) const;

  /// test_primitive() of the scene.
  std::optional<TriangleTest> test(const Ray& ray, std::uint32_t geom_id, std::uint32_t prim_id) const;

 private:
  const Scene& scene_;
  std::vector<MeshCull> culls_;
};

}  // namespace stbvh::harness
