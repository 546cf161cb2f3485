#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/microbenchmarks/benchmarks.h"
#include "harness/microbenchmarks/traversal_steps.h"
#include "stbvh/isa.h"

namespace stbvh::harness {
namespace {

/// Steps between two looks at the clock; a multiple of kRing.
constexpr std::size_t kBatch = 4096;

/// Measures run(kBatch); the time reported is that of one step. `expected`: what it returns for each step.
template <typename Run>
void register_step(const std::string& name, std::size_t expected, Run run) {
  benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    bool right = true;
    while (state.KeepRunningBatch(kBatch)) right &= run(kBatch) == expected * kBatch;
    if (!right) report_wrong_answer(state);
  });
}

template <typename Node>
void register_node(std::string_view kind, std::string_view test, const NodeSteps<Node>& steps) {
  const auto ring = std::make_shared<const NodeRing<Node>>();
  for (const auto& [measure, run] : {std::pair{"throughput", steps.throughput}, {"latency", steps.latency}}) {
    register_step(fmt::format("node/{}/{}/{}", kind, measure, test), kWidth,
                  [ring, run = run](std::size_t count) { return run(*ring, count); });
  }
}

void register_leaf(std::string_view name, LeafKind kind, std::string_view test, const TraversalSteps& steps) {
  const auto ring = std::make_shared<const LeafRing>(kind);
  for (const bool hits : {true, false}) {
    const Ray ray = hits ? LeafRing::hitting_ray() : LeafRing::missing_ray();
    for (const auto& [query, run] : {std::pair{"closest", steps.closest_hit}, {"any", steps.any_hit}}) {
      register_step(fmt::format("leaf/{}/{}/{}/{}", name, hits ? "hit" : "miss", query, test), hits ? 1 : 0,
                    [ring, ray, run = run](std::size_t count) { return run(*ring, ray, count); });
    }
  }
}

void register_test(std::string_view test, const TraversalSteps& steps) {
  register_node("static", test, steps.static_node);
  register_node("linear", test, steps.linear_node);
  register_node("spatial-temporal", test, steps.spatial_temporal_node);
  register_leaf("inline", LeafKind::kInline, test, steps);
  register_leaf("inline-static", LeafKind::kInlineStatic, test, steps);
  register_leaf("indexed", LeafKind::kIndexed, test, steps);
  const auto rays = std::make_shared<const RayRing>();
  register_step(fmt::format("setup_ray/{}", test), 1,
                [rays, run = steps.setup_ray](std::size_t count) { return run(*rays, count); });
}

bool wrong_answer = false;

}  // namespace

void register_steps() {
  const std::vector<Isa> isas = available_isas();
  if (std::find(isas.begin(), isas.end(), Isa::kAvx2) == isas.end()) {
    std::fprintf(stderr, "This machine has no AVX2 with FMA: the steps of that traversal are left out.\n");
    return;
  }
  register_test("watertight", kAvx2WatertightSteps);
  register_test("fast", kAvx2FastSteps);
}

bool any_wrong_answer() {
  return wrong_answer;
}

void report_wrong_answer(benchmark::State& state) {
  wrong_answer = true;
  state.SkipWithError("wrong answer");
}

}  // namespace stbvh::harness
