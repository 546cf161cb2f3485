#include "plugin/preload/group.h"

#include <atomic>
#include <chrono>
#include <new>

#include "plugin/callbacks.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/statistics.h"

namespace stbvh::preload {
namespace {

using plugin::MeshDescription;
using plugin::Published;

/// What a user geometry shows without a group. Never freed: Embree may keep it longer than anything else.
const Published& empty_published() {
  static const Published* const kEmpty = new Published;
  return *kEmpty;
}

constexpr std::align_val_t kAlignment{64};

void* allocate(TrackedDevice& device, std::size_t bytes) {
  if (!device.report_memory(static_cast<ssize_t>(bytes))) throw std::bad_alloc();
  void* const data = ::operator new(bytes, kAlignment, std::nothrow);
  if (data == nullptr) {
    device.report_memory(-static_cast<ssize_t>(bytes));
    throw std::bad_alloc();
  }
  count_bytes(static_cast<std::ptrdiff_t>(bytes));
  return data;
}

void release(TrackedDevice& device, void* data, std::size_t bytes) {
  ::operator delete(data, kAlignment);
  device.report_memory(-static_cast<ssize_t>(bytes));
  count_bytes(-static_cast<std::ptrdiff_t>(bytes));
}

/// The application's user data as it is now: it may be changed at any time.
void* user_data_of(void* geometry) {
  return real().rtcGetGeometryUserData(static_cast<RTCGeometry>(geometry));
}

/// Asked for once for each hit that filters see.
void* counting_user_data_of(void* geometry) {
  count_filtered_hit();
  return user_data_of(geometry);
}

unsigned active(const int* valid, unsigned size) {
  unsigned count = 0;
  for (unsigned i = 0; i < size; ++i) count += valid[i] != 0 ? 1 : 0;
  return count;
}

void counting_intersect(const RTCIntersectFunctionNArguments* arguments) {
  count_rays(active(arguments->valid, arguments->N));
  plugin::intersect_callback(arguments);
}

void counting_occluded(const RTCOccludedFunctionNArguments* arguments) {
  count_rays(active(arguments->valid, arguments->N));
  plugin::occluded_callback(arguments);
}

MeshDescription description_of(const Member& member) {
  const TrackedGeometry& mesh = *member.mesh;
  std::vector<const void*> vertices;
  std::vector<std::size_t> strides;
  for (unsigned step = 0; step < mesh.step_count; ++step) {
    vertices.push_back(mesh.vertices[step].data);
    strides.push_back(mesh.vertices[step].stride);
  }
  StbvhMeshArguments arguments;
  stbvhInitMeshArguments(&arguments);
  arguments.indices = mesh.indices.data;
  arguments.indexByteStride = mesh.indices.stride;
  arguments.triangleCount = mesh.indices.count;
  arguments.vertices = vertices.data();
  arguments.vertexByteStrides = strides.data();
  arguments.vertexCount = mesh.vertices[0].count;
  arguments.stepCount = mesh.step_count;
  arguments.startTime = mesh.time_range.begin;
  arguments.endTime = mesh.time_range.end;
  arguments.mask = mesh.mask;
  arguments.geomID = member.geom_id;
  return MeshDescription(arguments);
}

/// Two steps over [0, 1], or one if nothing moves.
plugin::MotionGrid grid_of(const std::vector<MeshView>& views) {
  LinearBox bounds;
  bool moves = false;
  for (const MeshView& view : views) {
    bounds.include(linear_bounds_of(view));
    moves |= view.steps.size() > 1;
  }
  if (moves) return {{0.0f, 1.0f}, {bounds.begin, bounds.end}};
  return {{0.0f, 1.0f}, {bounds.begin}};
}

std::unique_ptr<Published> publication(const std::vector<Member>& members, const GroupSettings& settings) {
  auto published = std::make_unique<Published>();
  published->runs_context_filters = settings.runs_context_filters;
  published->filter_user_ptr = counts_statistics() ? counting_user_data_of : user_data_of;
  for (const Member& member : members) {
    const TrackedGeometry& mesh = *member.mesh;
    published->descriptions.push_back(description_of(member));
    published->meshes.push_back({member.geom_id, mesh.handle, mesh.intersect_filter, mesh.occluded_filter});
    published->has_intersect_filters |= mesh.intersect_filter != nullptr;
    published->has_occluded_filters |= mesh.occluded_filter != nullptr;
  }
  return published;
}

unsigned union_of_masks(const Published& published) {
  unsigned mask = 0;
  for (const MeshDescription& mesh : published.descriptions) mask |= mesh.mask();
  return mask;
}

}  // namespace

Group::Group(std::shared_ptr<TrackedDevice> device)
    : device_(std::move(device)), proxy_(real().rtcNewGeometry(device_->handle(), RTC_GEOMETRY_TYPE_USER)) {
  if (proxy_ == nullptr) throw std::bad_alloc();
  real().rtcSetGeometryUserPrimitiveCount(proxy_, 1);
  real().rtcSetGeometryBoundsFunction(proxy_, plugin::bounds_callback, nullptr);
  const bool counts = counts_statistics();
  real().rtcSetGeometryIntersectFunction(proxy_, counts ? counting_intersect : plugin::intersect_callback);
  real().rtcSetGeometryOccludedFunction(proxy_, counts ? counting_occluded : plugin::occluded_callback);
  publish(empty_published());
}

Group::~Group() {
  real().rtcSetGeometryUserData(proxy_, const_cast<Published*>(&empty_published()));
  real().rtcReleaseGeometry(proxy_);
}

/// Makes `published` what the callbacks see, and what Embree knows of it.
void Group::publish(const Published& published) {
  // Embree's user data is not const; the callbacks only read it.
  real().rtcSetGeometryUserData(proxy_, const_cast<Published*>(&published));
  real().rtcSetGeometryTimeStepCount(proxy_, static_cast<unsigned>(published.grid.steps.size()));
  real().rtcSetGeometryMask(proxy_, union_of_masks(published));
  real().rtcCommitGeometry(proxy_);
}

void Group::clear() {
  publish(empty_published());
  published_.reset();
  members_.clear();
}

void Group::set_enabled(bool value) {
  value ? real().rtcEnableGeometry(proxy_) : real().rtcDisableGeometry(proxy_);
}

bool Group::is_built_of(const std::vector<Member>& members, const GroupSettings& settings) const {
  if (published_ == nullptr || !(settings == settings_) || members.size() != members_.size()) return false;
  for (std::size_t i = 0; i < members.size(); ++i) {
    // Versions are unique, so they tell meshes apart too.
    const bool same = members[i].geom_id == members_[i].geom_id && members[i].version == members_[i].version;
    if (!same) return false;
  }
  return true;
}

BuildCallbacks Group::callbacks(const std::function<bool(double)>& progress, bool& refused) const {
  BuildCallbacks result;
  // Their copies live in the structure, so they hold the device themselves.
  result.allocate = [device = device_](std::size_t bytes) { return allocate(*device, bytes); };
  result.release = [device = device_](void* data, std::size_t bytes) { release(*device, data, bytes); };
  result.temporary_memory = [device = device_, &refused](std::ptrdiff_t bytes) {
    if (device->report_memory(bytes)) return true;
    std::atomic_ref(refused).store(true, std::memory_order_relaxed);
    return false;
  };
  result.progress = progress;
  return result;
}

void Group::build(std::vector<Member> members, const GroupSettings& settings,
                  const std::function<bool(double)>& progress) {
  clear();
  const auto start = std::chrono::steady_clock::now();
  auto published = publication(members, settings);
  std::vector<MeshView> views;
  for (const MeshDescription& mesh : published->descriptions) views.push_back(mesh.view());
  bool refused = false;
  try {
    published->structure = Structure::build(views, settings.build, callbacks(progress, refused));
  } catch (const BuildCancelled&) {
    if (refused) throw std::bad_alloc();
    throw;
  }
  published->grid = grid_of(views);
  published_ = std::move(published);
  members_ = std::move(members);
  settings_ = settings;
  publish(*published_);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  count_build(published_->structure->statistics(), seconds.count());
}

}  // namespace stbvh::preload
