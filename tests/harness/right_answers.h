/// A structure's answers against the exact oracle's.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>

#include "harness/oracle/judge.h"
#include "harness/oracle/oracle.h"
#include "harness/rays/ray_generator.h"
#include "harness/structures/structure_under_test.h"
#include "tests/harness/trace_all.h"

namespace stbvh::harness {

/// Of rays through a scene of about 10 units, at least `least_hits` of which hit.
inline void expect_right_answers(const StructureUnderTest& structure, const Oracle& oracle,
                                 const RaySet& rays, std::size_t least_hits) {
  const ErrorCounts counts = judge(oracle, 17.0, rays, oracle.answers(rays.rays), trace_all(structure, rays));
  EXPECT_EQ(counts.traced, rays.rays.size());
  EXPECT_GT(counts.oracle_hits, least_hits);
  EXPECT_EQ(counts.missed, 0u) << ray_kind_name(rays.kind);
  EXPECT_EQ(counts.false_hits, 0u) << ray_kind_name(rays.kind);
  EXPECT_EQ(counts.wrong_primitive, 0u) << ray_kind_name(rays.kind);
  EXPECT_LT(counts.within_rounding, 5u) << ray_kind_name(rays.kind);
}

/// Of `count` rays of each kind.
inline void expect_right_answers(const StructureUnderTest& structure, const Scene& scene, std::size_t count,
                                 std::size_t least_hits) {
  const auto reference = build_structure("stbvh-direct", scene, 2);
  const Oracle oracle(scene);
  for (const RayKind kind : ray_kinds())
    expect_right_answers(structure, oracle, make_rays(kind, scene, *reference, count, 11), least_hits);
}

}  // namespace stbvh::harness
