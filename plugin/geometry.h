/// The set of meshes behind an StbvhGeometry, its tree and its RTCGeometry.
#pragma once

#include <memory>
#include <type_traits>
#include <vector>

#include "plugin/linked_embree.h"
#include "plugin/mesh_description.h"
#include "plugin/user_geometry.h"

namespace stbvh::plugin {

class TemporaryMemory;

/// Errors are thrown: ApiError, or std::bad_alloc.
class Geometry {
 public:
  /// Retains `device`, which must not be null.
  explicit Geometry(RTCDevice device);

  RTCDevice device() const { return device_.get(); }
  RTCGeometry rtc_geometry() const { return user_geometry_.handle(); }

  const std::vector<MeshDescription>& meshes() const { return meshes_; }

  void add_mesh(MeshDescription mesh);
  void set_mesh(std::size_t index, MeshDescription mesh);
  void set_precision(Precision precision);
  void set_max_bytes(std::size_t structure_bytes, std::size_t peak_bytes);
  void set_tolerance(float tolerance);
  void set_progress(RTCProgressMonitorFunction progress, void* user_ptr);

  /// Builds the tree and commits the RTCGeometry. On an exception the geometry is empty, and committed so.
  void commit();

  /// Of the tree in use, or null.
  const BuildStatistics* statistics() const;

  /// What the last commit built, or null.
  const Published* published() const { return user_geometry_.published(); }
  /// Index of the one mesh whose geomID is the default; RTC_INVALID_GEOMETRY_ID without one.
  unsigned default_mesh() const { return default_mesh_; }

 private:
  std::shared_ptr<const Published> build(TemporaryMemory& temporary_memory) const;
  BuildCallbacks build_callbacks(TemporaryMemory& temporary_memory) const;

  struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };

  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  UserGeometry<linked_embree> user_geometry_;
  std::vector<MeshDescription> meshes_;
  BuildSettings settings_;
  RTCProgressMonitorFunction progress_ = nullptr;
  void* progress_user_ptr_ = nullptr;
  unsigned default_mesh_ = RTC_INVALID_GEOMETRY_ID;
};

}  // namespace stbvh::plugin
