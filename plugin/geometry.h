/// The set of meshes behind an StbvhGeometry, its tree and its RTCGeometry.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "plugin/linked_embree.h"
#include "plugin/mesh_description.h"
#include "plugin/saved_motions.h"
#include "plugin/user_geometry.h"
#include "stbvh/mesh_fingerprint.h"

namespace stbvh::plugin {

class TemporaryMemory;

/// What a commit did, and what that cost.
struct CommitReport {
  BuildStatistics tree;
  UpdateStatistics update;  ///< of a tree built anew: of all meshes
  bool is_update = false;
  double seconds = 0.0;
};

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

  /// Builds the tree, or changes it where meshes have changed, and commits the RTCGeometry. On an exception
  /// the geometry is empty, and committed so.
  void commit() { commit(nullptr); }
  /// The same with the tree of a file that save() wrote: nothing is built.
  void commit_saved(const char* file) { commit(file); }
  /// Writes the tree that the last commit made. Throws OutputFileError too.
  void save(const char* file) const;

  /// What the last commit did, or null after one that failed.
  const CommitReport* report() const { return report_ ? &*report_ : nullptr; }

  /// What the last commit built, or null.
  const Published* published() const { return user_geometry_.published(); }
  /// Index of the one mesh whose geomID is the default; RTC_INVALID_GEOMETRY_ID without one.
  unsigned default_mesh() const { return default_mesh_; }

 private:
  /// What commit() needs to know of the meshes, and keeps for the next.
  struct Committed {
    BuildSettings settings;
    std::vector<MeshFingerprint> fingerprints;
    MotionsOfMeshes motions;
  };

  std::vector<MeshView> views() const;
  /// From a file, or without one of the meshes.
  void commit(const char* saved_file);
  // Both make `now.motions` too.
  std::shared_ptr<Structure> read_structure(const char* file, Committed& now,
                                            std::span<const MeshView> views) const;
  std::shared_ptr<Structure> make_structure(std::shared_ptr<Structure> old, Committed& now,
                                            std::span<const MeshView> views, BuildCallbacks callbacks,
                                            CommitReport& report);
  BuildCallbacks build_callbacks(TemporaryMemory& temporary_memory) const;

  struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };

  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  UserGeometry<linked_embree> user_geometry_;
  std::vector<MeshDescription> meshes_;
  BuildSettings settings_;
  Committed committed_;  ///< of what is published
  std::optional<CommitReport> report_;
  RTCProgressMonitorFunction progress_ = nullptr;
  void* progress_user_ptr_ = nullptr;
  unsigned default_mesh_ = RTC_INVALID_GEOMETRY_ID;
};

}  // namespace stbvh::plugin
