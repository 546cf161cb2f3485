/// Meshes of a scene in one structure, behind one user geometry.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "plugin/preload/linear_scene_bounds.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/tracked_device.h"
#include "plugin/preload/tracked_geometry.h"
#include "plugin/user_geometry.h"
#include "stbvh/mesh_fingerprint.h"

namespace stbvh::preload {

/// A mesh under the ID at which the application attached it.
struct Member {
  unsigned geom_id;
  std::shared_ptr<TrackedGeometry> mesh;
  std::uint64_t version;  ///< of the mesh when it was looked at
};

struct GroupSettings {
  BuildSettings build;
  bool runs_query_filters = false;

  bool operator==(const GroupSettings& other) const {
    return build == other.build && runs_query_filters == other.runs_query_filters;
  }
};

/// What Embree calls for the user geometry of a group.
struct GroupCallbacks {
  RTCIntersectFunctionN intersect;
  RTCOccludedFunctionN occluded;
};
const GroupCallbacks& group_callbacks();

/// Whether a user geometry with this user data is a group's.
bool is_group(const void* user_data);

/// From now on rays are looked at before Embree gets them (ray_calls.h): there is a group.
void look_at_rays();

class Group {
 public:
  /// Throws std::bad_alloc if Embree gives no geometry.
  explicit Group(std::shared_ptr<TrackedDevice> device);

  /// The user geometry to attach.
  RTCGeometry proxy() const { return user_geometry_.handle(); }

  /// Changes the structure where members have changed, or builds it anew after the old one is freed, and
  /// commits the user geometry. `progress` is given the fraction done and returns false to cancel. On an
  /// exception (BuildCancelled, std::bad_alloc, std::length_error, InvalidMesh) the group is empty.
  void build(std::vector<Member> members, const GroupSettings& settings,
             const std::function<bool(double)>& progress);

  /// Hits nothing from now on.
  void clear();
  /// Whether Embree's next build is to know of the user geometry.
  void set_enabled(bool value);

  /// Whether build() with these would do again what the last one did.
  bool is_built_of(const std::vector<Member>& members, const GroupSettings& settings) const;

  /// What the callbacks are shown; null: nothing.
  const plugin::Published* published() const { return user_geometry_.published(); }
  /// Of the structure; it must not be empty.
  const BuildStatistics& statistics() const { return user_geometry_.published()->structure->statistics(); }

 private:
  /// A member, with what its mesh was when it was built.
  struct Built {
    Member member;
    MeshFingerprint fingerprint;
    LinearBox box;  ///< that it shows
    bool moves;
  };

  std::vector<Built> look_at(const std::vector<Member>& members, std::span<const MeshView> views,
                             std::vector<MeshUpdate>& updates) const;
  BuildCallbacks callbacks(const std::function<bool(double)>& progress, bool& refused) const;

  std::shared_ptr<TrackedDevice> device_;
  plugin::UserGeometry<real> user_geometry_;
  std::vector<Built> members_;
  GroupSettings settings_;
};

}  // namespace stbvh::preload
