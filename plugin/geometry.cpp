#include "plugin/geometry.h"

#include <new>
#include <utility>

#include "plugin/callbacks.h"
#include "plugin/device_memory.h"
#include "plugin/step_bounds.h"

namespace stbvh::plugin {
namespace {

/// What geometries show that have no tree. Never freed: an RTCGeometry may outlive everything else.
const Published& empty_published() {
  static const Published* const kEmpty = new Published;
  return *kEmpty;
}

/// The union of the meshes' masks: Embree tests it before it calls, the kernels test each mesh's own.
unsigned union_of_masks(const Published& published) {
  unsigned mask = 0;
  for (const MeshDescription& mesh : published.descriptions) mask |= mesh.mask();
  return mask;
}

PublishedMesh published_mesh(const MeshDescription& mesh) {
  const StbvhMeshArguments arguments = mesh.arguments();
  return {arguments.geomID, arguments.userPtr, arguments.intersectFilter, arguments.occludedFilter};
}

/// Index of the mesh that has no geomID of its own, or RTC_INVALID_GEOMETRY_ID. Throws ApiError for two.
unsigned find_default_mesh(const std::vector<MeshDescription>& meshes) {
  unsigned found = RTC_INVALID_GEOMETRY_ID;
  for (unsigned i = 0; i < meshes.size(); ++i) {
    if (meshes[i].geom_id() != RTC_INVALID_GEOMETRY_ID) continue;
    if (found != RTC_INVALID_GEOMETRY_ID) {
      throw ApiError(RTC_ERROR_INVALID_OPERATION,
                     "meshes " + std::to_string(found) + " and " + std::to_string(i) +
                         " both have the default geomID, so that their hits could not be told apart: set " +
                         "geomID of all meshes but one");
    }
    found = i;
  }
  return found;
}

}  // namespace

Geometry::Geometry(RTCDevice device) : device_(device) {
  const Published& empty = empty_published();
  rtc_geometry_ = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  if (rtc_geometry_ == nullptr) throw std::bad_alloc();
  rtcRetainDevice(device_);
  rtcSetGeometryUserPrimitiveCount(rtc_geometry_, 1);
  rtcSetGeometryBoundsFunction(rtc_geometry_, bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(rtc_geometry_, intersect_callback);
  rtcSetGeometryOccludedFunction(rtc_geometry_, occluded_callback);
  show(empty);  // not committed: Embree refuses scenes with it until the application has done that
}

Geometry::~Geometry() {
  rtcSetGeometryUserData(rtc_geometry_, const_cast<Published*>(&empty_published()));
  rtcReleaseGeometry(rtc_geometry_);
  published_.reset();
  rtcReleaseDevice(device_);
}

void Geometry::add_mesh(MeshDescription mesh) {
  meshes_.push_back(std::move(mesh));
  require_commit();
}

void Geometry::set_mesh(std::size_t index, MeshDescription mesh) {
  meshes_[index] = std::move(mesh);
  require_commit();
}

void Geometry::set_precision(Precision precision) {
  settings_.precision = precision;
  require_commit();
}

void Geometry::set_inline_share(float share) {
  settings_.inline_share = share;
  require_commit();
}

/// As after a setter of Embree's own: scenes that hold the geometry are refused until it is committed.
void Geometry::require_commit() {
  rtcSetGeometryMask(rtc_geometry_, published_ == nullptr ? 0 : union_of_masks(*published_));
}

void Geometry::set_progress(RTCProgressMonitorFunction progress, void* user_ptr) {
  progress_ = progress;
  progress_user_ptr_ = user_ptr;
}

/// Makes `published` what the callbacks see, and what Embree will know of it after a commit.
void Geometry::show(const Published& published) {
  // Embree's user data is not const; the callbacks only read it.
  rtcSetGeometryUserData(rtc_geometry_, const_cast<Published*>(&published));
  rtcSetGeometryTimeStepCount(rtc_geometry_, static_cast<unsigned>(published.grid.steps.size()));
  rtcSetGeometryTimeRange(rtc_geometry_, published.grid.time_range.begin, published.grid.time_range.end);
  rtcSetGeometryMask(rtc_geometry_, union_of_masks(published));
}

void Geometry::publish(const Published& published) {
  show(published);
  rtcCommitGeometry(rtc_geometry_);
}

void Geometry::commit() {
  publish(empty_published());
  published_.reset();
  default_mesh_ = find_default_mesh(meshes_);
  TemporaryMemory temporary_memory(device_);
  try {
    published_ = build(temporary_memory);
  } catch (const BuildCancelled&) {
    if (temporary_memory.refused()) throw std::bad_alloc();
    throw ApiError(RTC_ERROR_CANCELLED, "the progress function cancelled the build");
  } catch (const InvalidMesh& error) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, error.what());
  }
  publish(*published_);
}

BuildCallbacks Geometry::build_callbacks(TemporaryMemory& temporary_memory) const {
  BuildCallbacks callbacks;
  callbacks.allocate = [device = device_](std::size_t bytes) { return allocate_on_device(device, bytes); };
  callbacks.release = [](void* data, std::size_t) { release_on_device(data); };
  callbacks.temporary_memory = [&temporary_memory](std::ptrdiff_t bytes) {
    return temporary_memory.report(bytes);
  };
  if (progress_ != nullptr) {
    callbacks.progress = [progress = progress_, user_ptr = progress_user_ptr_](double fraction) {
      return progress(user_ptr, fraction);
    };
  }
  return callbacks;
}

std::unique_ptr<Published> Geometry::build(TemporaryMemory& temporary_memory) const {
  auto published = std::make_unique<Published>();
  published->descriptions = meshes_;
  std::vector<MeshView> views;
  std::vector<MeshMotion> motions;
  const BuildCallbacks callbacks = build_callbacks(temporary_memory);
  for (const MeshDescription& mesh : published->descriptions) {
    views.push_back(mesh.view());
    motions.push_back({step_bounds(views.back(), callbacks.temporary_memory), views.back().time_range});
    published->meshes.push_back(published_mesh(mesh));
    published->has_intersect_filters |= published->meshes.back().intersect_filter != nullptr;
    published->has_occluded_filters |= published->meshes.back().occluded_filter != nullptr;
  }
  published->grid = fit_motion_grid(motions);
  published->structure = Structure::build(views, settings_, callbacks);
  return published;
}

const BuildStatistics* Geometry::statistics() const {
  return published_ == nullptr ? nullptr : &published_->structure->statistics();
}

}  // namespace stbvh::plugin
