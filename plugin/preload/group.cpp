#include "plugin/preload/group.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <new>
#include <unordered_map>
#include <utility>

#include "plugin/never_decreasing.h"
#include "plugin/preload/published_pool.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/statistics.h"

namespace stbvh::preload {
namespace {

using plugin::Published;

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

std::shared_ptr<Published> publication(const std::vector<Member>& members, const GroupSettings& settings) {
  auto published = std::allocate_shared<Published>(PublishedAllocator<Published>());
  published->runs_query_filters = settings.runs_query_filters;
  published->filter_user_ptr = counts_statistics() ? counting_user_data_of : user_data_of;
  for (const auto& [geom_id, mesh, version] : members) {
    published->add(
        {geom_id, mesh->handle, mesh->intersect_filter, mesh->occluded_filter, mesh->takes_query_filters},
        mesh->mask);
  }
  return published;
}

}  // namespace

const GroupCallbacks& group_callbacks() {
  static const GroupCallbacks kCallbacks =
      counts_statistics() ? GroupCallbacks{counting_intersect, counting_occluded}
                          : GroupCallbacks{plugin::intersect_callback, plugin::occluded_callback};
  return kCallbacks;
}

bool is_group(const void* user_data) {
  return is_in_published_pool(user_data) || user_data == &plugin::UserGeometry<real>::nothing();
}

Group::Group(std::shared_ptr<TrackedDevice> device)
    : device_(std::move(device)),
      user_geometry_(device_->handle(), group_callbacks().intersect, group_callbacks().occluded) {
  user_geometry_.publish(nullptr);
  look_at_rays();
}

void Group::clear() {
  user_geometry_.publish(nullptr);
  members_.clear();
}

void Group::set_enabled(bool value) {
  value ? real().rtcEnableGeometry(proxy()) : real().rtcDisableGeometry(proxy());
}

bool Group::is_built_of(const std::vector<Member>& members, const GroupSettings& settings) const {
  const bool may_be =
      user_geometry_.published() != nullptr && settings == settings_ && members.size() == members_.size();
  if (!may_be) return false;
  for (std::size_t i = 0; i < members.size(); ++i) {
    // Versions are unique, so they tell meshes apart too.
    const Member& built = members_[i].member;
    const bool same = members[i].geom_id == built.geom_id && members[i].version == built.version;
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
  result.progress = plugin::never_decreasing(std::cref(progress));
  return result;
}

/// What members have become of those that were built. All buffers are read: Embree builds of what they hold,
/// also where the application has not said that it changed them.
std::vector<Group::Built> Group::look_at(const std::vector<Member>& members, std::span<const MeshView> views,
                                         std::vector<MeshUpdate>& updates) const {
  std::unordered_map<const TrackedGeometry*, std::size_t> was;
  for (std::size_t i = 0; i < members_.size(); ++i) was.emplace(members_[i].member.mesh.get(), i);
  const std::vector<MeshFingerprint> fingerprints = fingerprints_of(views);
  std::vector<Built> built(members.size());
  std::vector<std::size_t> changed;
  std::vector<const MeshView*> changed_views;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const auto before = was.find(members[i].mesh.get());
    if (before != was.end()) {
      built[i] = members_[before->second];
      updates[i] = {before->second, change_between(built[i].fingerprint, fingerprints[i])};
      was.erase(before);  // a geometry may be attached twice
    }
    built[i].member = members[i];
    built[i].fingerprint = fingerprints[i];
    if (updates[i].change == MeshChange::kNothing) continue;
    built[i].moves = views[i].steps.size() > 1;
    changed.push_back(i);
    changed_views.push_back(&views[i]);
  }
  const std::vector<LinearBox> boxes = linear_bounds_of(changed_views);
  for (std::size_t i = 0; i < changed.size(); ++i) built[changed[i]].box = boxes[i];
  return built;
}

void Group::build(std::vector<Member> members, const GroupSettings& settings,
                  const std::function<bool(double)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  std::shared_ptr<Structure> structure;
  if (user_geometry_.published() != nullptr && settings.build == settings_.build)
    structure = user_geometry_.published()->structure;
  user_geometry_.publish(nullptr);
  auto published = publication(members, settings);
  std::vector<std::vector<VertexBufferView>> steps(members.size());
  std::vector<MeshView> views;
  for (std::size_t i = 0; i < members.size(); ++i) views.push_back(members[i].mesh->view(steps[i]));
  std::vector<MeshUpdate> updates(members.size());
  if (structure == nullptr) members_.clear();
  std::vector<Built> built = look_at(members, views, updates);
  members_.clear();
  bool refused = false;
  bool is_update = false;
  try {
    const BuildCallbacks building = callbacks(progress, refused);
    is_update = structure != nullptr && structure->update(views, updates, building).has_value();
    if (!is_update) {
      structure.reset();  // there is never memory for two
      structure = Structure::build(views, settings.build, building);
    }
  } catch (const BuildCancelled&) {
    if (refused) throw std::bad_alloc();
    throw;
  }
  LinearBox bounds;
  bool moves = false;
  for (const Built& member : built) {
    bounds.extend(member.box);
    moves |= member.moves;
  }
  // Two steps over [0, 1], or one if nothing moves.
  published->grid = {{0.0f, 1.0f}, {bounds.begin}};
  if (moves) published->grid.steps.push_back(bounds.end);
  published->structure = std::move(structure);
  members_ = std::move(built);
  settings_ = settings;
  user_geometry_.publish(std::move(published));
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  count_build(statistics(), is_update, seconds.count());
}

}  // namespace stbvh::preload
