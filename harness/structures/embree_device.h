/// Embree objects with owners, and errors as exceptions.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include "harness/scenes/scene.h"
#include "harness/structures/memory_monitor.h"
#include "harness/structures/structure_under_test.h"
#include "plugin/embree_api.h"

namespace stbvh::harness {

struct SceneRelease {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct GeometryRelease {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using ScenePtr = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;
using GeometryPtr = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, GeometryRelease>;

/// A device of one structure, with a memory monitor and the text of its last error.
class EmbreeDevice {
 public:
  /// `options` is appended to the device string; `threads` 0 takes all. Throws std::runtime_error.
  EmbreeDevice(std::string_view options, unsigned threads);
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  RTCDevice get() const { return device_; }
  const MemoryMonitor& memory() const { return memory_; }

  ScenePtr new_scene(RTCSceneFlags flags) const;

  /// Throws std::runtime_error (std::bad_alloc for want of memory) if a call failed since the last check.
  void check() const;

 private:
  MemoryMonitor memory_;
  std::string last_error_;
  RTCDevice device_ = nullptr;
};

/// A BuildProgress as Embree and the plugin take it: `progress` points to one.
bool report_progress(void* progress, double fraction);

/// Commits `scene`. Throws BuildCancelled where `progress` returned false.
void commit_scene(const EmbreeDevice& device, RTCScene scene, const BuildProgress& progress);

/// Steps `first_step` to `first_step + step_count - 1` of `mesh` over `time_range` as Embree's own triangles,
/// on the mesh's own buffers, committed.
GeometryPtr new_triangle_geometry(const EmbreeDevice& device, const Mesh& mesh, std::size_t first_step,
                                  std::size_t step_count, TimeRange time_range);

/// Embree's own triangles over all meshes of `scene` that have any, geomIDs as in `scene`, committed.
ScenePtr new_triangle_scene(const EmbreeDevice& device, const Scene& scene, RTCSceneFlags flags,
                            const BuildProgress& progress = {});

}  // namespace stbvh::harness
