/// Commits: what is taken over, and when Embree has anything to do.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "plugin/preload/environment.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/scene_changes.h"
#include "plugin/preload/statistics.h"
#include "plugin/preload/tracked_scene.h"
#include "stbvh/stbvh_embree.h"

namespace stbvh::preload {
namespace {

bool refuse(void*, double) {
  return false;
}

/// A commit that failed, as the application will hear of it.
struct CommitError {
  RTCError code;
  const char* message;
  std::exception_ptr cause = std::current_exception();  ///< to whom the message may belong
};

}  // namespace

GroupSettings TrackedScene::group_settings(const Plan& plan) const {
  const RTCSceneFlags flags = real().rtcGetSceneFlags(handle_);
  GroupSettings settings;
  settings.runs_query_filters = plan.has_filters || (flags & plugin::kSceneTakesQueryFilters) != 0;
  settings.build.max_bytes = environment().max_bytes;
  if (environment().fast && (flags & RTC_SCENE_FLAG_ROBUST) == 0) {
    settings.build.precision = Precision::kFast;
  }
  return settings;
}

TrackedScene::Plan TrackedScene::make_plan() const {
  const std::lock_guard lock(mutex_);
  Plan plan;
  plan.attached = attachments_.size();
  plan.contents.push_back(edits_);
  for (const auto& [geom_id, attachment] : attachments_) {
    const std::shared_ptr<TrackedGeometry>& geometry = attachment.geometry;
    if (geometry == nullptr) {
      plan.is_certain = false;
      plan.has_others = true;
      continue;
    }
    plan.contents.insert(plan.contents.end(), {geom_id, geometry->version});
    // What Embree refuses shall be refused by Embree.
    if (geometry->enabled && !geometry->committed) plan.is_certain = false;
    for (const auto& instanced : geometry->instanced) {
      if (instanced != nullptr) plan.contents.push_back(instanced->commits());
    }
    StaysNative reason = StaysNative::kNone;
    if (geometry->type == RTC_GEOMETRY_TYPE_TRIANGLE) {
      reason = geometry->why_native();
      if (reason == StaysNative::kNone) reason = device_->why_native();
      plan.meshes.emplace_back(geometry, reason);
    }
    if (!geometry->enabled) continue;
    plan.has_filters |= geometry->has_filters();
    if (geometry->type == RTC_GEOMETRY_TYPE_TRIANGLE && reason == StaysNative::kNone) {
      plan.members.push_back({geom_id, geometry, geometry->version});
    } else if (reason == StaysNative::kOneStep) {
      plan.at_rest.push_back({plan.meshes.size() - 1, {geom_id, geometry, geometry->version}});
    } else {
      plan.has_others = true;
    }
  }
  plan.takes_what_rests = !plan.at_rest.empty() && plan.may_take_what_rests();
  if (plan.takes_what_rests) {
    for (auto& [mesh, member] : plan.at_rest) {
      plan.meshes[mesh].second = StaysNative::kNone;
      plan.members.push_back(member);
    }
    std::ranges::sort(plan.members, {}, &Member::geom_id);
  }
  plan.has_others |= !plan.at_rest.empty() && !plan.takes_what_rests;
  plan.contents.push_back(plan.takes_what_rests);
  return plan;
}

/// Where nothing else is in the scene, and at least half of it moves: then rays need not go through Embree,
/// which is worth more than its tree of what is at rest (docs/preload.md, Speed). Each of the meshes must be
/// in this scene alone: Embree knows for a mesh, not for a scene, whether it is switched off.
bool TrackedScene::Plan::may_take_what_rests() const {
  if (has_others || members.empty()) return false;
  std::size_t moving = 0, resting = 0;
  for (const Member& member : members) moving += member.mesh->indices.count;
  for (const auto& [mesh, member] : at_rest) resting += member.mesh->indices.count;
  return resting <= moving && std::ranges::all_of(at_rest, [](const auto& entry) {
           const TrackedGeometry& mesh = *entry.second.mesh;
           return mesh.attachments == 1 && mesh.why_native_but_for_rest() == StaysNative::kNone;
         });
}

void TrackedScene::set_own_share(double share) {
  const std::lock_guard lock(mutex_);
  own_share_ = share;
}

void TrackedScene::build_group(const Plan& plan, CommitTurns::Turn& turn) {
  const GroupSettings settings = group_settings(plan);
  set_own_share(0);
  if (group_->is_built_of(plan.members, settings)) return;
  const double share = static_cast<double>(plan.members.size()) / static_cast<double>(plan.attached);
  set_own_share(share);
  turn.run([&] {
    group_->build(plan.members, settings, [&](double fraction) { return report_progress(share * fraction); });
  });
}

/// The user geometry stays attached here too, for Embree's build may fail, but it is switched off.
TrackedScene::Next TrackedScene::give_all_to_embree() {
  const bool had_group = has_group();
  if (had_group) {
    group_->clear();
    group_->set_enabled(false);
  }
  const std::lock_guard lock(mutex_);
  is_clean_ = false;
  if (!had_group) return Next::kForward;
  has_group_ = false;
  contents_.clear();
  return Next::kForward;
}

/// After a failure of ours: as after one of Embree's the scene hits nothing, until a commit succeeds.
/// Embree's own build is cancelled for that, and its error is swallowed, as there is to be one only. The user
/// geometry stays attached: of several trees of a scene Embree may keep some that name it.
void TrackedScene::cancel_embrees_build() {
  const Muted muted(*device_);
  real().rtcSetSceneProgressMonitorFunction(handle_, refuse, nullptr);
  real().rtcCommitScene(handle_);
  const std::lock_guard lock(mutex_);
  is_clean_ = false;
  real().rtcSetSceneProgressMonitorFunction(handle_, progress_ == nullptr ? nullptr : native_progress, this);
}

TrackedScene::Next TrackedScene::carry_out(const Plan& plan, CommitTurns::Turn& turn) {
  for (const auto& [mesh, reason] : plan.meshes) {
    mesh->give_to_embree(reason != StaysNative::kNone);
    if (mesh->enabled) count_mesh(*mesh, reason);
  }
  if (plan.members.empty()) return give_all_to_embree();
  {
    const std::lock_guard lock(mutex_);
    if (is_clean_ && plan.is_certain && plan.contents == contents_) return Next::kNothing;
    is_clean_ = false;
  }
  if (group_ == nullptr) group_ = std::make_unique<Group>(device_);
  build_group(plan, turn);
  const std::lock_guard lock(mutex_);
  attach_proxy();
  group_->set_enabled(true);
  has_group_ = true;
  has_others_ = plan.has_others;
  contents_ = plan.contents;
  return Next::kForward;
}

/// Throws CommitError.
TrackedScene::Next TrackedScene::prepare(CommitTurns::Turn& turn) {
  Plan plan;
  try {
    plan = make_plan();
    const Next next = carry_out(plan, turn);
    say(plan);
    return next;
  } catch (const std::length_error&) {
    return prepare_without(plan, turn);
  } catch (const MemoryLimit&) {
    return prepare_without(plan, turn);
  } catch (const BuildCancelled&) {
    throw CommitError{RTC_ERROR_CANCELLED, "progress monitor forced termination"};
  } catch (const std::bad_alloc&) {
    throw CommitError{RTC_ERROR_OUT_OF_MEMORY, "no memory, or the memory monitor forced termination"};
  } catch (const std::exception& error) {
    throw CommitError{RTC_ERROR_UNKNOWN, error.what()};
  }
}

TrackedScene::Next TrackedScene::prepare_without(const Plan& plan, CommitTurns::Turn& turn) {
  if (plan.takes_what_rests) {
    for (const auto& [mesh, member] : plan.at_rest) member.mesh->too_large = true;
  } else {
    for (const Member& member : plan.members) member.mesh->too_large = true;
  }
  return prepare(turn);
}

void TrackedScene::say(const Plan& plan) const {
  if (!environment().verbose || plan.meshes.empty()) return;
  std::string left;
  for (const auto& [mesh, reason] : plan.meshes) {
    if (reason == StaysNative::kNone || !mesh->enabled) continue;
    left += left.empty() ? "; left to Embree: " : ", ";
    left += describe(reason);
  }
  std::fprintf(stderr, "libstbvh_preload: scene %p: %zu meshes taken over%s\n",
               static_cast<const void*>(handle_), plan.members.size(), left.c_str());
}

/// Embree takes a scene with a switched-off geometry for modified at every commit, so a thread that joins
/// when the others are done builds it again. Nobody returns from here, to trace rays, while another may do
/// that.
void TrackedScene::forward(bool join) {
  const ErrorWatch watch;
  std::unique_lock lock(mutex_);
  if (is_clean_) return;  // what this thread prepared another has had built
  if (forwarding_++ == 0) has_failed_ = false;
  lock.unlock();
  join ? real().rtcJoinCommitScene(handle_) : real().rtcCommitScene(handle_);
  lock.lock();
  has_failed_ |= watch.failed();
  commits_ = unique_number();
  if (--forwarding_ == 0) {
    is_clean_ = !has_failed_;
    forwarded_.notify_all();
  }
  forwarded_.wait(lock, [&] { return forwarding_ == 0; });
}

void TrackedScene::commit(bool join) {
  struct AtTheEnd {
    bool has_changed = true;
    ~AtTheEnd() {
      if (has_changed) scenes_changed();
    }
  } at_the_end;
  try {
    Next next;
    {
      CommitTurns::Turn turn(turns_);
      if (join && turn.found_failure()) return;
      try {
        next = prepare(turn);
      } catch (const CommitError&) {
        turn.failed();
        count_failed_build();
        cancel_embrees_build();
        throw;
      }
    }
    at_the_end.has_changed = next == Next::kForward;
    if (next == Next::kForward) forward(join);
  } catch (const CommitError& error) {
    device_->raise(error.code, error.message);
  }
}

}  // namespace stbvh::preload
