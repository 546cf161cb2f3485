/// What the program measures, registered with Google Benchmark. Each checks that the answers are right:
/// what is fast because it does nothing is not measured.
#pragma once

#include <benchmark/benchmark.h>

namespace stbvh::harness {

/// Single steps of the AVX2 traversal, all they need in the first-level cache. None without AVX2 and FMA.
void register_steps();

/// Whole queries on structures that fit into the first two levels of cache: through our kernels, through
/// Embree with the plugin, and through Embree's own triangles.
void register_whole_queries();

/// Whole queries on scenes that no cache holds: how much of a ray's time is computing, and how much waiting
/// for memory. Builds scenes for seconds.
void register_waiting();

/// Whole queries on moving scenes, and on the same scenes at rest, built for the moment of the rays: what the
/// motion costs, and with it the most that a better tree could bring. Builds scenes for seconds.
void register_frozen();

/// What Embree itself costs: queries of an empty scene, and of a user geometry whose callbacks only count.
void register_embree_calls();

/// Whether a benchmark met a wrong answer.
bool any_wrong_answer();
/// Ends the benchmark as failed, and notes that one did.
void report_wrong_answer(benchmark::State& state);

}  // namespace stbvh::harness
