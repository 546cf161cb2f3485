/// Scenes for the queries that a user geometry cannot answer.
#pragma once

#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "plugin/embree_api.h"

namespace stbvh::preload {

class TrackedScene;

/// A scene again, built by Embree of its own triangles: copies of the taken-over meshes that share their
/// buffers, instances of such scenes that show their twins, and everything else as it is. Made when it is
/// first asked for, and again after a commit.
class NativeTwin {
 public:
  NativeTwin() = default;
  ~NativeTwin();
  NativeTwin(const NativeTwin&) = delete;
  NativeTwin& operator=(const NativeTwin&) = delete;

  /// The scene to ask instead of `scene`, whose twin this is: the twin, or the scene itself where nothing in
  /// it, nor in what it shows by instances, is taken over. Any thread may call.
  RTCScene scene_to_ask(TrackedScene& scene);

 private:
  /// The scenes it was made of, by address and number of commits.
  using Origin = std::vector<std::pair<const TrackedScene*, std::uint64_t>>;

  static void collect_origin(const TrackedScene& scene, Origin& origin);
  static RTCScene make(TrackedScene& scene);

  std::mutex mutex_;
  RTCScene twin_ = nullptr;
  Origin origin_;
};

/// The scene to ask instead of `scene` for point queries and collisions. Quick from the second call on.
RTCScene scene_to_ask(RTCScene scene);

}  // namespace stbvh::preload
