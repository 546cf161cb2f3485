/// What the application said of a geometry.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "plugin/embree_api.h"
#include "plugin/preload/registry.h"
#include "plugin/preload/stays_native.h"
#include "plugin/preload/unique_number.h"
#include "stbvh/mesh_view.h"

namespace stbvh::preload {

class TrackedScene;

/// A buffer as it was bound; its contents are read at commit.
struct BoundBuffer {
  RTCFormat format = RTC_FORMAT_UNDEFINED;
  const void* data = nullptr;
  std::size_t stride = 0;
  std::size_t count = 0;
};

/// One step of an instance's motion, as the application gave it.
struct InstanceTransform {
  enum class Kind { kNone, kMatrix, kQuaternion } kind = Kind::kNone;
  RTCFormat format = RTC_FORMAT_UNDEFINED;
  std::array<float, 16> matrix{};
  RTCQuaternionDecomposition quaternion{};
};

/// All kinds of geometries are tracked, for the sake of knowing whether a scene changed; triangle meshes and
/// instances in full. As in Embree, setters of one geometry are for one thread at a time.
class TrackedGeometry {
 public:
  TrackedGeometry(RTCGeometry own_handle, RTCGeometryType own_type, RTCDevice own_device)
      : handle(own_handle), type(own_type), device(own_device) {}
  ~TrackedGeometry();
  TrackedGeometry(const TrackedGeometry&) = delete;
  TrackedGeometry& operator=(const TrackedGeometry&) = delete;

  /// After a setter: rtcCommitGeometry has to follow.
  void modified();
  /// After one of those behind which it need not.
  void touched();
  void was_committed();

  /// The application's switch. Embree is told unless the mesh is taken over, for then it is off there.
  void set_enabled(bool value);
  /// Whether Embree itself shall answer for the mesh, as far as the application has it enabled.
  void give_to_embree(bool value);

  bool has_filters() const {
    return intersect_filter != nullptr || occluded_filter != nullptr || takes_query_filters;
  }

  /// Whether a group answers for it instead.
  bool is_taken_over();

  /// Does not look at whether it is enabled, nor at the device, nor at what else the scene holds.
  StaysNative why_native() const;
  /// Apart from being at rest.
  StaysNative why_native_but_for_rest() const;

  /// As the kernels take it, for a mesh that does not stay native; `vertices` becomes what it points to.
  MeshView view(std::vector<VertexBufferView>& vertices) const;

  const RTCGeometry handle;
  const RTCGeometryType type;
  const RTCDevice device;

  unsigned step_count = 1;
  TimeRange time_range;
  unsigned mask = STBVH_DEFAULT_MASK;
  RTCFilterFunctionN intersect_filter = nullptr;
  RTCFilterFunctionN occluded_filter = nullptr;
  bool takes_query_filters = false;  ///< also of queries that have none for all meshes
  RTCPointQueryFunction point_query = nullptr;
  BoundBuffer indices;             ///< of an instance array: which scene each shows, if not the only one
  std::vector<BoundBuffer> steps;  ///< vertices, or transformations of an instance array

  std::vector<std::shared_ptr<TrackedScene>> instanced;  ///< null: not created through this library
  std::vector<InstanceTransform> transforms;             ///< of an instance, by step

  std::atomic<unsigned> attachments = 0;  ///< in all scenes
  bool enabled = true;
  bool committed = false;
  bool too_large = false;     ///< found out by a build: never again
  bool is_known = true;       ///< false: there was no memory to record a setter
  std::uint64_t version = 0;  ///< unique_number() at each change

  /// For statistics: what this mesh was counted for, bit 0: taken over, bit i: reason i.
  unsigned counted = 0;

 private:
  bool has_buffers() const;
  bool can_be_built() const;

  std::mutex mutex_;
  bool natively_enabled_ = true;
  bool given_to_embree_ = true;
};

/// Of all devices.
Registry<RTCGeometry, TrackedGeometry>& geometries();

}  // namespace stbvh::preload
