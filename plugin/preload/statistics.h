/// What this library did in this process.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plugin/preload/tracked_geometry.h"
#include "stbvh/structure.h"

namespace stbvh::preload {

/// Whether STBVH_PRELOAD_STATISTICS asks for them; without it nothing is counted.
bool counts_statistics();

/// Has them written when the process ends; for rtcNewDevice.
void report_statistics_at_exit();

void count_device();

/// A mesh that a commit took over, or left to Embree for a reason; each is counted once for each.
void count_mesh(TrackedGeometry& mesh, StaysNative reason);

/// `is_update`: the structure was changed, not built anew.
void count_build(const BuildStatistics& built, bool is_update, double seconds);
void count_failed_build();
/// Bytes of structures that came (+) or went (-).
void count_bytes(std::ptrdiff_t bytes);
/// A scene built with Embree's own triangles for queries that only those answer.
void count_native_twin();

/// Rays of this thread that our structures were asked about.
void count_rays(unsigned count);
/// A hit of this thread that a filter of the application is asked about.
void count_filtered_hit();

}  // namespace stbvh::preload
