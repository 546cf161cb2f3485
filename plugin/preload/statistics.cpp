#include "plugin/preload/statistics.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "plugin/files/open_file.h"
#include "plugin/files/output_file.h"
#include "plugin/preload/environment.h"

namespace stbvh::preload {
namespace {

struct Totals {
  std::array<std::size_t, kStaysNativeCount> meshes{};  ///< by StaysNative; kNone: taken over
  std::size_t triangles = 0, invalid_triangles = 0, segments = 0;
  std::size_t devices = 0, builds = 0, updates = 0, failed_builds = 0, native_twins = 0;
  double build_seconds = 0;
  std::ptrdiff_t bytes = 0, peak_bytes = 0;
};

/// A thread's own: nobody else writes it, so it needs no atomic addition.
class Counter {
 public:
  void add(std::uint64_t count) { value_.store(value() + count, std::memory_order_relaxed); }
  std::uint64_t value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

struct ThreadCounters {
  Counter rays, filtered_hits;
};

struct Statistics {
  std::mutex mutex;
  Totals totals;
  std::vector<ThreadCounters*> threads;  ///< never freed
};

Statistics& statistics() {
  static auto* const kStatistics = new Statistics;  // outlives what runs at exit
  return *kStatistics;
}

ThreadCounters& new_thread_counters() {
  auto* const counters = new ThreadCounters;
  const std::lock_guard lock(statistics().mutex);
  statistics().threads.push_back(counters);
  return *counters;
}

ThreadCounters& thread_counters() {
  thread_local ThreadCounters& counters = new_thread_counters();
  return counters;
}

template <typename Change>
void change_totals(Change&& change) {
  if (!counts_statistics()) return;
  const std::lock_guard lock(statistics().mutex);
  change(statistics().totals);
}

nlohmann::ordered_json to_json(const Totals& totals, std::uint64_t rays, std::uint64_t filtered_hits) {
  nlohmann::ordered_json left = nlohmann::ordered_json::object();
  for (std::size_t reason = 1; reason < kStaysNativeCount; ++reason) {
    if (totals.meshes[reason] > 0) left[describe(static_cast<StaysNative>(reason))] = totals.meshes[reason];
  }
  return {{"devices", totals.devices},
          {"meshes_taken_over", totals.meshes[0]},
          {"triangles", totals.triangles},
          {"invalid_triangles", totals.invalid_triangles},
          {"segments", totals.segments},
          {"rays", rays},
          {"filtered_hits", filtered_hits},
          {"builds", totals.builds},
          {"updates", totals.updates},
          {"failed_builds", totals.failed_builds},
          {"build_seconds", totals.build_seconds},
          {"bytes", totals.bytes},
          {"peak_bytes", totals.peak_bytes},
          {"native_twins", totals.native_twins},
          {"meshes_left_native", left}};
}

/// At the end of a process that used Embree; others, such as a shell that starts it, say nothing.
void report() {
  const std::lock_guard lock(statistics().mutex);
  std::uint64_t rays = 0, filtered_hits = 0;
  for (const ThreadCounters* const thread : statistics().threads) {
    rays += thread->rays.value();
    filtered_hits += thread->filtered_hits.value();
  }
  const std::string text = to_json(statistics().totals, rays, filtered_hits).dump(2);
  const std::string& path = *environment().statistics;
  if (path.empty()) {
    std::fprintf(stderr, "libstbvh_preload: %s\n", text.c_str());
    return;
  }
  struct stat status {};
  std::optional<OpenFile> pipe;  // stays open: who reads it would take the closing for its end
  if (stat(path.c_str(), &status) == 0 && S_ISFIFO(status.st_mode)) {
    pipe.emplace(path, O_WRONLY | O_NONBLOCK);
    if (!pipe->is_open()) {  // the program would wait at its end
      std::fprintf(stderr, "libstbvh_preload: the statistics: Nobody reads \"%s\".\n", path.c_str());
      return;
    }
  }
  try {
    write_file(path, text + '\n');
  } catch (const OutputFileError& error) {
    std::fprintf(stderr, "libstbvh_preload: the statistics: %s\n", error.what());
  }
}

}  // namespace

bool counts_statistics() {
  static const bool kCounts = environment().enabled && environment().statistics.has_value();
  return kCounts;
}

void report_statistics_at_exit() {
  if (!counts_statistics()) return;
  static const bool kRegistered = std::atexit(report) == 0;
  static_cast<void>(kRegistered);
}

void count_device() {
  change_totals([](Totals& totals) { ++totals.devices; });
}

void count_mesh(TrackedGeometry& mesh, StaysNative reason) {
  change_totals([&](Totals& totals) {
    const unsigned bit = 1u << static_cast<unsigned>(reason);
    if ((mesh.counted & bit) == 0) ++totals.meshes[static_cast<std::size_t>(reason)];
    mesh.counted |= bit;
  });
}

void count_build(const BuildStatistics& built, bool is_update, double seconds) {
  change_totals([&](Totals& totals) {
    totals.build_seconds += seconds;
    if (is_update) {
      ++totals.updates;
      return;
    }
    ++totals.builds;
    totals.triangles += built.triangles;
    totals.invalid_triangles += built.invalid_triangles;
    totals.segments += built.primitive_segments;
  });
}

void count_failed_build() {
  change_totals([](Totals& totals) { ++totals.failed_builds; });
}

void count_bytes(std::ptrdiff_t bytes) {
  change_totals([&](Totals& totals) {
    totals.bytes += bytes;
    totals.peak_bytes = std::max(totals.peak_bytes, totals.bytes);
  });
}

void count_native_twin() {
  change_totals([](Totals& totals) { ++totals.native_twins; });
}

void count_rays(unsigned count) {
  thread_counters().rays.add(count);
}

void count_filtered_hit() {
  thread_counters().filtered_hits.add(1);
}

}  // namespace stbvh::preload
