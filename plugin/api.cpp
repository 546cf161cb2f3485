/// The C functions: argument checks, reference counts, and exceptions turned into error codes.
#include <atomic>
#include <cmath>
#include <cstddef>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "plugin/callbacks.h"
#include "plugin/device_error.h"
#include "plugin/geometry.h"
#include "plugin/versioned_struct.h"

struct StbvhGeometryTy {
  explicit StbvhGeometryTy(RTCDevice device) : geometry(device) {
    error_message.reserve(kMessageBytes);  // "out of memory" shall find room
  }

  static constexpr std::size_t kMessageBytes = 128;

  std::atomic<std::size_t> references{1};
  std::string error_message;
  stbvh::plugin::Geometry geometry;
};

namespace {

using stbvh::plugin::ApiError;
using stbvh::plugin::MeshDescription;
using stbvh::plugin::new_context;
using stbvh::plugin::QueryContext;
using stbvh::plugin::Rays;
using stbvh::plugin::set_device_error;

static_assert(std::string_view(STBVH_VERSION_STRING) == STBVH_PROJECT_VERSION);

/// Of this thread: why the last call failed that had no handle. A literal: it takes no memory.
thread_local const char* error_message_without_handle = "";

// Messages before errors: the device's error function may ask for them.
RTCError fail_without_handle(RTCDevice device, RTCError code, const char* message) noexcept {
  error_message_without_handle = message;
  set_device_error(device, code);
  return code;
}

RTCError fail(StbvhGeometry handle, RTCError code, const char* message) noexcept {
  try {
    handle->error_message = message;
  } catch (const std::bad_alloc&) {
    handle->error_message.clear();
  }
  set_device_error(handle->geometry.device(), code);
  return code;
}

constexpr const char* kNullGeometry = "geometry is null";

/// Runs `function` on the handle; whatever it throws becomes a code and a message.
template <typename Function>
RTCError guarded(StbvhGeometry handle, Function&& function) noexcept {
  if (handle == nullptr) return fail_without_handle(nullptr, RTC_ERROR_INVALID_ARGUMENT, kNullGeometry);
  try {
    function(handle->geometry);
    return RTC_ERROR_NONE;
  } catch (const ApiError& error) {
    return fail(handle, error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(handle, RTC_ERROR_OUT_OF_MEMORY, "out of memory, or the device's memory monitor refused");
  } catch (const std::exception& error) {
    return fail(handle, RTC_ERROR_UNKNOWN, error.what());
  } catch (...) {
    return fail(handle, RTC_ERROR_UNKNOWN, "unknown exception");
  }
}

/// Asks what the last commit built: `ask` is intersect or occluded, `options` what the query brings. Others
/// may query the handle at once, so its message stays as it is: only the device is told of what filters
/// throw.
template <typename Options, typename Ray>
void query(StbvhGeometry handle, Options* options,
           void (*ask)(const stbvh::plugin::Published&, unsigned, QueryContext*, stbvh::plugin::QueryFilter,
                       Rays<Ray>),
           Rays<Ray> rays) noexcept {
  if (handle == nullptr) {
    fail_without_handle(nullptr, RTC_ERROR_INVALID_ARGUMENT, kNullGeometry);
    return;
  }
  const stbvh::plugin::Geometry& geometry = handle->geometry;
  if (rays.count == 0) return;
  if (rays.first == nullptr ||
      (rays.count > 1 && (rays.stride < sizeof(Ray) || rays.stride % alignof(float) != 0 ||
                          !stbvh::fits_into_memory(rays.first, rays.count, rays.stride, sizeof(Ray)))))
    return set_device_error(geometry.device(), RTC_ERROR_INVALID_ARGUMENT);
  if (geometry.published() == nullptr) return;
  QueryContext plain = new_context();
  try {
    ask(*geometry.published(), geometry.default_mesh(), stbvh::plugin::context_of(options, plain),
        stbvh::plugin::filter_of(options), rays);
  } catch (const std::bad_alloc&) {
    set_device_error(geometry.device(), RTC_ERROR_OUT_OF_MEMORY);
  } catch (...) {
    set_device_error(geometry.device(), RTC_ERROR_UNKNOWN);
  }
}

void require(const void* pointer, const char* name) {
  if (pointer == nullptr) throw ApiError(RTC_ERROR_INVALID_ARGUMENT, std::string(name) + " is null");
}

const MeshDescription& mesh_at(const stbvh::plugin::Geometry& geometry, unsigned index) {
  if (index >= geometry.meshes().size()) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "meshIndex is " + std::to_string(index) + ", but there are " +
                                                   std::to_string(geometry.meshes().size()) + " meshes");
  }
  return geometry.meshes()[index];
}

// The least that describes a mesh, and what was built; a header that ends sooner there is none. Members are
// not to be put where an older header has padding (4 bytes behind geomID): it would be read.
constexpr std::size_t kFirstMeshArgumentsSize = offsetof(StbvhMeshArguments, geomID);
constexpr std::size_t kFirstStatisticsSize = offsetof(StbvhStatistics, invalidTriangles);

StbvhMeshArguments read_arguments(const StbvhMeshArguments* arguments) {
  require(arguments, "arguments");
  StbvhMeshArguments defaults;
  stbvhInitMeshArguments(&defaults);
  return stbvh::plugin::read_versioned(arguments, defaults, kFirstMeshArgumentsSize, "arguments");
}

}  // namespace

extern "C" {

unsigned stbvhGetVersion(void) {
  return STBVH_VERSION;
}

StbvhGeometry stbvhNewGeometry(RTCDevice device) {
  if (device == nullptr) {
    fail_without_handle(device, RTC_ERROR_INVALID_ARGUMENT, "device is null");
    return nullptr;
  }
  try {
    return new StbvhGeometryTy(device);
  } catch (const std::exception&) {
    fail_without_handle(device, RTC_ERROR_OUT_OF_MEMORY, "out of memory for another geometry");
    return nullptr;
  }
}

void stbvhRetainGeometry(StbvhGeometry geometry) {
  if (geometry != nullptr) geometry->references.fetch_add(1, std::memory_order_relaxed);
}

void stbvhReleaseGeometry(StbvhGeometry geometry) {
  if (geometry == nullptr) return;
  if (geometry->references.fetch_sub(1, std::memory_order_acq_rel) == 1) delete geometry;
}

RTCError stbvhAddMesh(StbvhGeometry geometry, const StbvhMeshArguments* arguments, unsigned* meshIndex) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    const auto index = static_cast<unsigned>(g.meshes().size());
    g.add_mesh(MeshDescription(read_arguments(arguments)));
    if (meshIndex != nullptr) *meshIndex = index;
  });
}

RTCError stbvhSetMesh(StbvhGeometry geometry, unsigned meshIndex, const StbvhMeshArguments* arguments) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    mesh_at(g, meshIndex);
    g.set_mesh(meshIndex, MeshDescription(read_arguments(arguments)));
  });
}

RTCError stbvhGetMesh(StbvhGeometry geometry, unsigned meshIndex, StbvhMeshArguments* arguments) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    require(arguments, "arguments");
    stbvh::plugin::write_versioned(arguments, mesh_at(g, meshIndex).arguments(), kFirstMeshArgumentsSize,
                                   "arguments");
  });
}

unsigned stbvhGetMeshCount(StbvhGeometry geometry) {
  return geometry == nullptr ? 0 : static_cast<unsigned>(geometry->geometry.meshes().size());
}

RTCError stbvhSetGeometryPrecision(StbvhGeometry geometry, StbvhPrecision precision) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    switch (precision) {
      case STBVH_PRECISION_WATERTIGHT:
        return g.set_precision(stbvh::Precision::kWatertight);
      case STBVH_PRECISION_FAST:
        return g.set_precision(stbvh::Precision::kFast);
    }
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "precision is not one of enum StbvhPrecision");
  });
}

RTCError stbvhSetGeometryMaxBytes(StbvhGeometry geometry, size_t structureBytes, size_t peakBytes) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) { g.set_max_bytes(structureBytes, peakBytes); });
}

RTCError stbvhSetGeometryTolerance(StbvhGeometry geometry, float tolerance) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    if (!(tolerance >= 0.0f && std::isfinite(tolerance)) && tolerance != STBVH_KEEP_ALL_STEPS) {
      throw ApiError(RTC_ERROR_INVALID_ARGUMENT,
                     "tolerance is neither finite and at least 0, nor STBVH_KEEP_ALL_STEPS");
    }
    g.set_tolerance(tolerance);
  });
}

RTCError stbvhSetGeometryProgressFunction(StbvhGeometry geometry, RTCProgressMonitorFunction progress,
                                          void* userPtr) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) { g.set_progress(progress, userPtr); });
}

RTCError stbvhCommitGeometry(StbvhGeometry geometry) {
  return guarded(geometry, [](stbvh::plugin::Geometry& g) { g.commit(); });
}

RTCError stbvhSaveGeometry(StbvhGeometry geometry, const char* file) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    require(file, "file");
    g.save(file);
  });
}

RTCError stbvhCommitSavedGeometry(StbvhGeometry geometry, const char* file) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    require(file, "file");
    g.commit_saved(file);
  });
}

RTCGeometry stbvhGetGeometry(StbvhGeometry geometry) {
  return geometry == nullptr ? nullptr : geometry->geometry.rtc_geometry();
}

#if RTC_VERSION_MAJOR >= 4

void stbvhIntersect1(StbvhGeometry geometry, RTCRayHit* rayhit, RTCIntersectArguments* arguments) {
  query(geometry, arguments, stbvh::plugin::intersect, Rays<RTCRayHit>{rayhit});
}

void stbvhOccluded1(StbvhGeometry geometry, RTCRay* ray, RTCOccludedArguments* arguments) {
  query(geometry, arguments, stbvh::plugin::occluded, Rays<RTCRay>{ray});
}

void stbvhIntersectN(StbvhGeometry geometry, RTCRayHit* rayhits, size_t count, size_t byteStride,
                     RTCIntersectArguments* arguments) {
  query(geometry, arguments, stbvh::plugin::intersect, Rays<RTCRayHit>{rayhits, count, byteStride});
}

void stbvhOccludedN(StbvhGeometry geometry, RTCRay* rays, size_t count, size_t byteStride,
                    RTCOccludedArguments* arguments) {
  query(geometry, arguments, stbvh::plugin::occluded, Rays<RTCRay>{rays, count, byteStride});
}

void stbvhIntersectFunctionN(const RTCIntersectFunctionNArguments* arguments) {
  stbvh::plugin::intersect_callback(arguments);
}

void stbvhOccludedFunctionN(const RTCOccludedFunctionNArguments* arguments) {
  stbvh::plugin::occluded_callback(arguments);
}

#else

void stbvhIntersect1(StbvhGeometry geometry, RTCIntersectContext* context, RTCRayHit* rayhit) {
  query(geometry, context, stbvh::plugin::intersect, Rays<RTCRayHit>{rayhit});
}

void stbvhOccluded1(StbvhGeometry geometry, RTCIntersectContext* context, RTCRay* ray) {
  query(geometry, context, stbvh::plugin::occluded, Rays<RTCRay>{ray});
}

void stbvhIntersectN(StbvhGeometry geometry, RTCIntersectContext* context, RTCRayHit* rayhits, size_t count,
                     size_t byteStride) {
  query(geometry, context, stbvh::plugin::intersect, Rays<RTCRayHit>{rayhits, count, byteStride});
}

void stbvhOccludedN(StbvhGeometry geometry, RTCIntersectContext* context, RTCRay* rays, size_t count,
                    size_t byteStride) {
  query(geometry, context, stbvh::plugin::occluded, Rays<RTCRay>{rays, count, byteStride});
}

#endif

RTCError stbvhGetStatistics(StbvhGeometry geometry, StbvhStatistics* statistics) {
  return guarded(geometry, [&](stbvh::plugin::Geometry& g) {
    require(statistics, "statistics");
    const stbvh::plugin::CommitReport* const report = g.report();
    const stbvh::BuildStatistics values = report == nullptr ? stbvh::BuildStatistics{} : report->tree;
    const stbvh::UpdateStatistics update = report == nullptr ? stbvh::UpdateStatistics{} : report->update;
    const StbvhStatistics result{.byteSize = sizeof(StbvhStatistics),
                                 .triangles = values.triangles,
                                 .invalidTriangles = values.invalid_triangles,
                                 .primitiveSegments = values.primitive_segments,
                                 .structureBytes = values.structure_bytes,
                                 .peakBytes = values.peak_bytes,
                                 .stepsGiven = values.steps_given,
                                 .stepsKept = values.steps_kept,
                                 .maxDeviation = values.max_deviation,
                                 .wantedBytes = values.wanted_bytes,
                                 .leaves = values.inline_leaves + values.indexed_leaves,
                                 .indexedLeaves = values.indexed_leaves,
                                 .isUpdate = report != nullptr && report->is_update ? 1u : 0u,
                                 .meshesRefitted = update.meshes_refitted,
                                 .meshesBuilt = update.meshes_built,
                                 .meshesRemoved = update.meshes_removed,
                                 .leavesRefitted = update.leaves_refitted,
                                 .expectedCost = report == nullptr ? 0.0 : update.expected_cost,
                                 .commitSeconds = report == nullptr ? 0.0 : report->seconds};
    stbvh::plugin::write_versioned(statistics, result, kFirstStatisticsSize, "statistics");
  });
}

const char* stbvhGetErrorMessage(StbvhGeometry geometry) {
  return geometry == nullptr ? error_message_without_handle : geometry->error_message.c_str();
}

}  // extern "C"
