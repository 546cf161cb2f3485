/// Setters: first Embree's, then, if that took it, our record of it.
#pragma once

#include <new>

#include "plugin/preload/tracked_device.h"
#include "plugin/preload/tracked_geometry.h"

namespace stbvh::preload {

/// Calls `native`, which sets something of `geometry`, and `record` with what we know of that. `kChange`:
/// what the setter is to Embree.
template <auto kChange = &TrackedGeometry::modified, typename Native, typename Record>
void set_and_record(RTCGeometry geometry, Native&& native, Record&& record) {
  const ErrorWatch watch;
  native();
  if (watch.failed()) return;
  const auto tracked = geometries().find(geometry);
  if (tracked == nullptr) return;
  (tracked.get()->*kChange)();
  try {
    record(*tracked);
  } catch (const std::bad_alloc&) {
    tracked->is_known = false;
    if (const auto device = find_device(tracked->device)) device->raise_out_of_memory();
  }
}

/// For what we need not know in detail.
template <typename Native>
void set_and_note(RTCGeometry geometry, Native&& native) {
  set_and_record(geometry, native, [](TrackedGeometry&) {});
}

/// Takes note of a buffer of a mesh, or of an instance array.
void record_buffer(TrackedGeometry& geometry, RTCBufferType type, unsigned slot, const BoundBuffer& buffer);

}  // namespace stbvh::preload
