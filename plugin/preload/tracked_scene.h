/// A scene of the application, and what of it our structure answers.
#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "plugin/embree_api.h"
#include "plugin/preload/commit_turns.h"
#include "plugin/preload/group.h"
#include "plugin/preload/native_twin.h"
#include "plugin/preload/registry.h"
#include "plugin/preload/tracked_device.h"
#include "plugin/preload/tracked_geometry.h"

namespace stbvh::preload {

/// What the application attached under an ID.
struct Attachment {
  RTCGeometry handle;
  std::shared_ptr<TrackedGeometry> geometry;  ///< null: not created through this library
};
using Attachments = std::map<unsigned, Attachment>;

/// Taken-over meshes stay attached to Embree's scene, where they keep their IDs, but disabled; the group's
/// user geometry is attached beside them, some way above the application's IDs. It stays there for as long as
/// possible: a scene that was changed and not yet committed may still be traced as part of another.
class TrackedScene {
 public:
  TrackedScene(RTCScene handle, std::shared_ptr<TrackedDevice> device)
      : handle_(handle), device_(std::move(device)), turns_(device_->thread_limit()) {}
  ~TrackedScene();
  TrackedScene(const TrackedScene&) = delete;
  TrackedScene& operator=(const TrackedScene&) = delete;

  /// As the functions of Embree with these names, for any number of threads.
  unsigned attach(RTCGeometry geometry);
  void attach_by_id(RTCGeometry geometry, unsigned geom_id);
  void detach(unsigned geom_id);

  void set_progress(RTCProgressMonitorFunction function, void* user_ptr);
  /// After a setter of Embree's scene.
  void modified();

  /// rtcCommitScene, or rtcJoinCommitScene.
  void commit(bool join);

  RTCScene handle() const { return handle_; }
  const std::shared_ptr<TrackedDevice>& device() const { return device_; }
  Attachments attachments() const;
  /// Whether a structure of ours answers for meshes attached to this very scene.
  bool has_group() const;
  /// What answers for the whole scene, without Embree; null where that is not so.
  const plugin::Published* answers_alone() const;
  /// Another number after each commit that may have changed something.
  std::uint64_t commits() const;
  NativeTwin& twin() { return twin_; }

 private:
  /// What a look at everything attached says.
  struct Plan {
    bool may_take_what_rests() const;

    std::vector<std::pair<std::shared_ptr<TrackedGeometry>, StaysNative>> meshes;  ///< triangle meshes
    std::vector<Member> members;
    std::vector<std::pair<std::size_t, Member>> at_rest;  ///< places in `meshes` of those of one step
    bool takes_what_rests = false;                        ///< then they are members too
    std::size_t attached = 0;
    bool has_others = false;              ///< that Embree answers for
    bool has_filters = false;             ///< then Embree runs those of queries, whatever the scene's flags
    std::vector<std::uint64_t> contents;  ///< IDs and versions of everything
    bool is_certain = true;               ///< equal `contents` mean that nothing has changed
  };
  enum class Next { kForward, kNothing };

  Plan make_plan() const;
  Next carry_out(const Plan& plan, CommitTurns::Turn& turn);
  Next give_all_to_embree();
  void build_group(const Plan& plan, CommitTurns::Turn& turn);
  Next prepare(CommitTurns::Turn& turn);
  /// Where no structure over all of the plan may be as large as it would have to be.
  Next prepare_without(const Plan& plan, CommitTurns::Turn& turn);
  void cancel_embrees_build();
  void forward(bool join);
  void set_own_share(double share);
  Attachments::node_type new_attachment(RTCGeometry geometry);
  void enter(Attachments::node_type attachment, unsigned geom_id);
  void remove(unsigned geom_id);
  template <typename Change>
  void edit(bool needs_proxys_id, Change&& change);
  bool attach_proxy_as(unsigned geom_id);
  void attach_proxy();
  void withdraw_proxy();
  void say(const Plan& plan) const;
  GroupSettings group_settings(const Plan& plan) const;
  static bool native_progress(void* scene, double fraction);
  bool report_progress(double fraction);

  const RTCScene handle_;
  const std::shared_ptr<TrackedDevice> device_;

  mutable std::mutex mutex_;  ///< of what follows; not held while anything is built
  Attachments attachments_;
  std::optional<unsigned> proxy_id_;
  bool has_group_ = false;
  bool has_others_ = false;
  RTCProgressMonitorFunction progress_ = nullptr;
  void* progress_user_ptr_ = nullptr;
  double own_share_ = 0;  ///< of the progress of the commit under way
  std::uint64_t edits_ = 0;
  std::uint64_t commits_ = 0;
  std::vector<std::uint64_t> contents_;  ///< at the last commit
  bool is_clean_ = false;                ///< Embree has built `contents_`
  unsigned forwarding_ = 0;              ///< threads in Embree's commit; it tells one of them of a failure
  bool has_failed_ = false;
  std::condition_variable forwarded_;  ///< no thread is in Embree's commit

  CommitTurns turns_;
  std::unique_ptr<Group> group_;  ///< changed by who has the turn
  NativeTwin twin_;
};

/// Of all devices.
Registry<RTCScene, TrackedScene>& scenes();

}  // namespace stbvh::preload
