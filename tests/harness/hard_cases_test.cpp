/// The catalogue of hard cases in small: our structures answer every one rightly, whether denormals are
/// flushed to zero while they trace or not.
#include "harness/hard_cases/hard_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "harness/hard_cases/judged_case.h"
#include "tests/kernels/flush_to_zero.h"

namespace stbvh::harness {
namespace {

using test::FlushToZero;

constexpr std::size_t kRays = 2000;
constexpr std::string_view kOurs[] = {"stbvh-direct", "stbvh-direct-indexed", "stbvh-direct-scalar", "stbvh"};

std::vector<std::string> small_families() {
  std::vector<std::string> names;
  for (const HardFamily& family : hard_families()) {
    if (!family.is_large) names.push_back(family.name);
  }
  return names;
}

HardCounts trace(const JudgedCase& judged, const StructureUnderTest& structure, bool flush) {
  HardCounts counts;
  for (std::size_t batch = 0; batch < judged.batch_count(); ++batch) {
    const std::vector<Ray>& rays = judged.closest(batch).rays;
    std::vector<HitRecord> closest(rays.size());
    std::vector<HitRecord> any(rays.size());
    {
      const FlushToZero guard(flush);
      structure.intersect(rays, closest);
      structure.occluded(rays, any);
    }
    judged.judge_batch(batch, closest, any, counts);
  }
  finish(counts);
  return counts;
}

void expect_right(const HardCounts& counts) {
  EXPECT_EQ(counts.leaks, 0u) << counts.example;
  EXPECT_EQ(counts.errors.missed, 0u) << counts.example;
  EXPECT_EQ(counts.errors.false_hits, 0u) << counts.example;
  EXPECT_EQ(counts.errors.wrong_primitive, 0u) << counts.example;
  EXPECT_EQ(counts.any_wrong, 0u) << counts.example;
}

class EachFamily : public ::testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(HardCases, EachFamily, ::testing::ValuesIn(small_families()),
                         [](const auto& param_info) {
                           std::string name = param_info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(EachFamily, IsAnsweredRightlyByOurs) {
  const HardFamily& family = *find_hard_family(GetParam());
  std::size_t traced = 0;
  for (const HardCase& hard : family.make(kRays, 1)) {
    const JudgedCase judged(hard);
    traced += hard.rays.size();
    for (const std::string_view name : kOurs) {
      if (!family.admits(name)) continue;
      SCOPED_TRACE(name);
      if (judged.must_be_refused()) {
        EXPECT_THROW(build_structure(name, hard.scene, 0), std::exception);
        continue;
      }
      const auto structure = build_structure(name, hard.scene, 0);
      for (const bool flush : {false, true}) {
        SCOPED_TRACE(flush ? "flushing denormals" : "keeping denormals");
        expect_right(trace(judged, *structure, flush));
      }
    }
  }
  EXPECT_GT(traced, 0u);
  EXPECT_LE(traced, kRays);
}

TEST(Catalogue, FamiliesHaveTheirOwnNamesAndOneSentence) {
  std::set<std::string> names;
  for (const HardFamily& family : hard_families()) {
    EXPECT_TRUE(names.insert(family.name).second) << family.name;
    EXPECT_TRUE(family.description.ends_with('.')) << family.name;
    EXPECT_EQ(find_hard_family(family.name), &family);
  }
  EXPECT_EQ(find_hard_family("no-such"), nullptr);
}

TEST(Catalogue, SameSeedSameRays) {
  const HardFamily* family = find_hard_family("needles-1e4");
  const auto first = family->make(100, 3);
  const auto again = family->make(100, 3);
  const auto other = family->make(100, 4);
  EXPECT_EQ(first[0].rays[99].direction.x, again[0].rays[99].direction.x);
  EXPECT_NE(first[0].rays[99].direction.x, other[0].rays[99].direction.x);
}

TEST(JudgedCase, CountsLeaksMissesAndFalseHits) {
  const HardCase hard = std::move(find_hard_family("closed-2k-1")->make(100, 1).front());
  const JudgedCase judged(hard);
  const HitRecord nothing{0, kInvalidId, kInvalidId};
  const HitRecord absurd{1, 7, 7};
  HardCounts missed;
  judged.judge_batch(0, std::vector(100, nothing), std::vector(100, nothing), missed);
  EXPECT_EQ(missed.leaks, 100u);
  EXPECT_EQ(missed.errors.missed + missed.errors.within_rounding, 100u);
  EXPECT_FALSE(missed.is_right());
  EXPECT_NE(missed.example, "");
  HardCounts wrong;
  judged.judge_batch(0, std::vector(100, absurd), std::vector(100, absurd), wrong);
  EXPECT_EQ(wrong.leaks, 0u);
  EXPECT_EQ(wrong.errors.false_hits, 100u);
}

TEST(JudgedCase, InvalidRaysMayHitNothing) {
  const HardCase hard = std::move(find_hard_family("nan-rays")->make(10, 1).front());
  const JudgedCase judged(hard);
  const std::vector<HitRecord> hits(10, HitRecord{1, 0, 0});
  HardCounts counts;
  judged.judge_batch(0, hits, hits, counts);
  EXPECT_EQ(counts.errors.false_hits, 10u);
  EXPECT_EQ(counts.any_wrong, 10u);
}

TEST(JudgedCase, RefusalsNeedAnError) {
  const HardCase hard = std::move(find_hard_family("too-many-steps")->make(10, 1).front());
  const JudgedCase judged(hard);
  HardCounts counts;
  judged.judge_refusal("too many steps", counts);
  EXPECT_TRUE(counts.is_right());
  judged.judge_refusal("", counts);
  EXPECT_FALSE(counts.is_right());
}

}  // namespace
}  // namespace stbvh::harness
