/// The geometry through which Embree asks one of our structures.
#pragma once

#include <memory>
#include <new>
#include <utility>

#include "plugin/callbacks.h"
#include "plugin/published.h"

namespace stbvh::plugin {

/// An RTCGeometry of one primitive that shows a Published, or nothing. It may outlive this object, and hits
/// nothing then.
///
/// `kEmbree` returns something with the functions of Embree as members: a library that stands before Embree
/// must not call its own.
template <auto kEmbree>
class UserGeometry {
 public:
  /// It shows nothing, and is not committed: Embree refuses scenes with it until then. Throws std::bad_alloc
  /// if Embree gives no geometry.
  explicit UserGeometry(RTCDevice device, RTCIntersectFunctionN intersect = intersect_callback,
                        RTCOccludedFunctionN occluded = occluded_callback) {
    const Published& first = nothing();  // for which there may be no memory
    handle_ = kEmbree().rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (handle_ == nullptr) throw std::bad_alloc();
    kEmbree().rtcSetGeometryUserPrimitiveCount(handle_, 1);
    kEmbree().rtcSetGeometryBoundsFunction(handle_, bounds_callback, nullptr);
    kEmbree().rtcSetGeometryIntersectFunction(handle_, intersect);
    kEmbree().rtcSetGeometryOccludedFunction(handle_, occluded);
    show(first);
  }
  ~UserGeometry() {
    set_user_data(nothing());
    kEmbree().rtcReleaseGeometry(handle_);
  }
  UserGeometry(const UserGeometry&) = delete;
  UserGeometry& operator=(const UserGeometry&) = delete;

  RTCGeometry handle() const { return handle_; }
  const Published* published() const { return published_.get(); }  ///< null: nothing

  /// Shows `published` (null: nothing) from now on, and commits. What was shown before is freed.
  void publish(std::shared_ptr<const Published> published) {
    show(published == nullptr ? nothing() : *published);
    kEmbree().rtcCommitGeometry(handle_);
    published_ = std::move(published);
  }

  /// As after a setter of Embree's own: scenes that hold the geometry are refused until it is committed.
  void require_commit() {
    kEmbree().rtcSetGeometryMask(handle_, published_ == nullptr ? nothing().mask : published_->mask);
  }

  /// The user data of a geometry that shows nothing. Never freed: an RTCGeometry may outlive everything else.
  static const Published& nothing() {
    static const Published* const kNothing = new Published;
    return *kNothing;
  }

 private:
  void set_user_data(const Published& published) {
    // Embree's user data is not const; the callbacks only read it.
    kEmbree().rtcSetGeometryUserData(handle_, const_cast<Published*>(&published));
  }

  /// Makes `published` what the callbacks see, and what Embree will know of it after a commit.
  void show(const Published& published) {
    set_user_data(published);
    const MotionGrid& grid = published.grid;
    kEmbree().rtcSetGeometryTimeStepCount(handle_, static_cast<unsigned>(grid.steps.size()));
    kEmbree().rtcSetGeometryTimeRange(handle_, grid.time_range.begin, grid.time_range.end);
    kEmbree().rtcSetGeometryMask(handle_, published.mask);
  }

  RTCGeometry handle_ = nullptr;
  std::shared_ptr<const Published> published_;
};

}  // namespace stbvh::plugin
