#include "tree_update.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "builder/binary_tree.h"
#include "builder/encoder.h"
#include "builder/mbsah.h"
#include "builder/mesh_parts.h"
#include "builder/step_bounds.h"
#include "edit/insertion.h"
#include "edit/tree_edit.h"

namespace stbvh {

namespace {

/// Meshes of more than this share of all triangles are not built by themselves: the whole is built anew.
constexpr double kMostBuilt = 0.5;
/// Refitting may leave rays this much more to do, in shares of all that they have; else the meshes that moved
/// are built by themselves, if they are few: their leaves have gone away from those beside them.
constexpr double kMostRefitting = 1.01;
/// A tree in which rays have more than this to do, in shares of what they would have in a new one, is built
/// anew.
constexpr double kMostArea = 1.06;
/// So is one whose block is unused to more than this share.
constexpr double kMostUnused = 0.25;
/// A block that must grow becomes this share larger than it must be.
constexpr std::size_t kSpareShare = 16;

constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

class Update {
 public:
  Update(StoredTree& tree, std::span<const MeshView> meshes, std::span<const MeshUpdate> updates,
         const BuildCallbacks& callbacks)
      : tree_(tree), meshes_(meshes), updates_(updates), callbacks_(callbacks) {
    inner_ = callbacks;
    inner_.progress = [this](double fraction) { return report(fraction); };
  }

  /// False where the tree should be built anew.
  bool run() {
    if (updates_.size() != meshes_.size()) throw std::invalid_argument("not one update for each mesh");
    if (tree_.is_empty || tree_.settings.max_peak_bytes != kNoLimit) return false;
    find_out();
    if (!is_small()) return false;
    try {
      if (!edit_leaves() || !add_meshes()) return false;
    } catch (const BlockIsFull&) {
      return false;
    }
    refresh();
    if (!is_good()) return false;
    done_ = 1.0;
    if (!report(0.0)) throw BuildCancelled();
    return true;
  }

  const UpdateStatistics& statistics() const { return statistics_; }
  std::size_t peak_bytes() const { return peak_bytes_; }

 private:
  /// Two stages: what was there, what is new. Of threads that report at once only one is heard.
  bool report(double fraction) {
    if (!callbacks_.progress) return true;
    const std::unique_lock lock(report_, std::try_to_lock);
    if (!lock.owns_lock()) return true;
    if (is_cancelled_) return false;
    reported_ = std::max(reported_, done_ + share_ * fraction);
    is_cancelled_ = !callbacks_.progress(std::min(reported_, 1.0));
    return !is_cancelled_;
  }

  /// What becomes of each record, and which meshes are to be built.
  void find_out() {
    std::size_t meshes = 0;  // that were there
    for (std::uint32_t record = 0; record < tree_.meshes.size(); ++record) {
      if (tree_.meshes.entry(record).is_used)
        meshes = std::max<std::size_t>(meshes, tree_.meshes.record(record).index + 1);
    }
    std::vector<std::size_t> now(meshes, kNowhere);
    for (std::size_t i = 0; i < updates_.size(); ++i) {
      // Of several that say they were the same the first is it.
      const std::size_t was = updates_[i].was;
      if (was < meshes && now[was] == kNowhere) now[was] = i;
    }
    index_of_record_.assign(tree_.meshes.size(), kNowhere);
    find_moved(now);
    fates_.assign(tree_.meshes.size(), RecordEdit::Fate::kStays);
    std::vector<bool> is_gone(meshes), is_kept(meshes_.size());
    for (std::uint32_t record = 0; record < tree_.meshes.size(); ++record) {
      if (!tree_.meshes.entry(record).is_used) continue;
      const std::uint32_t was = tree_.meshes.record(record).index;
      const std::size_t index = now[was];
      fates_[record] = index == kNowhere ? RecordEdit::Fate::kRemoved : fate_of(record, index);
      if (fates_[record] != RecordEdit::Fate::kRemoved) {
        index_of_record_[record] = index;
        is_kept[index] = true;
      } else if ((index == kNowhere || is_empty(index)) && !is_gone[was]) {
        ++statistics_.meshes_removed;
        is_gone[was] = true;  // with its other parts
      }
    }
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      if (!is_kept[i]) new_meshes_.push_back(i);
    }
  }

  /// Reads what meshes with other positions are now, where leaves may stay what they are but for these.
  /// `now`: which mesh each has become.
  void find_moved(std::span<const std::size_t> now) {
    moved_.resize(tree_.meshes.size());
    tbb::parallel_for(std::size_t{0}, moved_.size(), [&](std::size_t record) {
      const MeshEntry& entry = tree_.meshes.entry(static_cast<std::uint32_t>(record));
      if (!entry.is_used || entry.is_part || entry.invalid_triangles > 0) return;
      const std::size_t index = now[tree_.meshes.record(static_cast<std::uint32_t>(record)).index];
      if (index == kNowhere || updates_[index].change != MeshChange::kPositions) return;
      // Nothing but positions may differ from what would be built now.
      BuildContext context(tree_.settings, inner_);
      add_mesh(context, meshes_[index], index);
      BuildMesh& mesh = context.meshes[0];
      if (mesh.is_part() || mesh.has_invalid_vertices() || mesh.steps_kept() != entry.kept) return;
      moved_[record].emplace(std::move(mesh));
    });
  }

  /// Of the record of a mesh that is still there, as number `index`.
  RecordEdit::Fate fate_of(std::uint32_t record, std::size_t index) const {
    if (updates_[index].change == MeshChange::kNothing) return RecordEdit::Fate::kStays;
    return moved_[record] ? RecordEdit::Fate::kMoved : RecordEdit::Fate::kRemoved;
  }

  bool is_empty(std::size_t index) const { return meshes_[index].triangle_count == 0; }

  bool is_small() const {
    std::size_t built = 0;
    for (const std::size_t index : new_meshes_) built += meshes_[index].triangle_count;
    return static_cast<double>(built) <= kMostBuilt * static_cast<double>(triangles());
  }

  /// False where nothing is left.
  bool edit_leaves() {
    share_ = 0.0;
    BuildProgress progress(inner_);
    progress.start();
    return remove(records_to(RecordEdit::Fate::kRemoved), progress, tree_.counts.expected_area) &&
           refit(progress);
  }

  bool refit(const BuildProgress& progress) {
    const std::vector<std::uint32_t> moved = records_to(RecordEdit::Fate::kMoved);
    if (moved.empty()) return true;
    const double before = tree_.counts.expected_area;
    TreeEdit edit(tree_.block.data(), tree_.space, tree_.meshes.records(),
                  edits(moved, RecordEdit::Fate::kMoved), progress);
    apply(edit);
    for (const std::uint32_t record : moved)
      tree_.meshes.entry(record).bounds.extend(to_box3f(edit.bounds()[record]));
    const bool have_gone_away =
        tree_.counts.expected_area > kMostRefitting * before &&
        static_cast<double>(triangles_of(moved)) <= kMostBuilt * static_cast<double>(triangles());
    const std::vector<std::uint32_t> built = have_gone_away ? moved : edit.torn_records();
    for (const std::uint32_t record : built) new_meshes_.push_back(index_of_record_[record]);
    std::vector<bool> is_built(fates_.size());
    for (const std::uint32_t record : built) is_built[record] = true;
    for (const std::uint32_t record : moved) {
      if (!is_built[record]) enter_refitted(record, edit);
    }
    if (!have_gone_away) statistics_.leaves_refitted = edit.leaves_moved();
    return remove(built, progress, before);
  }

  void enter_refitted(std::uint32_t record, const TreeEdit& edit) {
    MeshEntry& entry = tree_.meshes.entry(record);
    entry.bounds = to_box3f(edit.bounds()[record]);
    entry.deviation = moved_[record]->deviation();
    ++statistics_.meshes_refitted;
    if (!callbacks_.step_bounds) return;
    const BuildMesh& mesh = *moved_[record];
    callbacks_.step_bounds(mesh.index(), step_bounds(mesh), mesh.view().step_times);
  }

  std::size_t triangles() const {
    std::size_t all = 0;
    for (const MeshView& mesh : meshes_) all += mesh.triangle_count;
    return all;
  }
  std::size_t triangles_of(std::span<const std::uint32_t> records) const {
    std::size_t some = 0;
    for (const std::uint32_t record : records) some += meshes_[index_of_record_[record]].triangle_count;
    return some;
  }

  std::vector<std::uint32_t> records_to(RecordEdit::Fate fate) const {
    std::vector<std::uint32_t> records;
    for (std::uint32_t record = 0; record < fates_.size(); ++record) {
      if (fates_[record] == fate) records.push_back(record);
    }
    return records;
  }

  std::vector<RecordEdit> edits(std::span<const std::uint32_t> records, RecordEdit::Fate fate) const {
    std::vector<RecordEdit> result(tree_.meshes.size());
    for (const std::uint32_t record : records) {
      const BuildMesh* const mesh = moved_[record] ? &*moved_[record] : nullptr;
      result[record] = {fate, mesh, to_box4(tree_.meshes.entry(record).bounds)};
    }
    return result;
  }

  /// Takes all leaves of the records out, and forgets them. `before` is the expected area of the tree as it
  /// was when they were good ones: one without them would have as much less as this is less then.
  bool remove(std::span<const std::uint32_t> records, const BuildProgress& progress, double before) {
    if (records.empty()) return true;
    TreeEdit edit(tree_.block.data(), tree_.space, tree_.meshes.records(),
                  edits(records, RecordEdit::Fate::kRemoved), progress);
    if (!apply(edit)) return false;
    tree_.usual_area += tree_.counts.expected_area - before;
    for (const std::uint32_t record : records) {
      index_of_record_[record] = kNowhere;
      tree_.meshes.remove(record);
    }
    return true;
  }

  bool apply(TreeEdit& edit) {
    const TreeEdit::Outcome outcome = edit.apply(tree_.root.link, tree_.root.range);
    if (outcome.is_gone) return false;
    if (outcome.is_changed) tree_.root = outcome.slot;
    tree_.counts.add(outcome.change);
    return true;
  }

  bool add_meshes() {
    std::ranges::sort(new_meshes_);
    share_ = 1.0 / static_cast<double>(std::max<std::size_t>(new_meshes_.size(), 1));
    for (std::size_t i = 0; i < new_meshes_.size(); ++i) {
      done_ = share_ * static_cast<double>(i);
      if (!add(new_meshes_[i])) return false;
    }
    return true;
  }

  bool add(std::size_t index) {
    BuildContext context(tree_.settings, inner_);
    add_mesh(context, meshes_[index], index);
    BinaryTree built(context);
    tell_step_bounds(context, callbacks_);
    built.build(std::numeric_limits<double>::infinity());
    const std::vector<std::uint32_t> records = tree_.meshes.add(context, built);
    index_of_record_.resize(tree_.meshes.size(), kNowhere);
    for (const std::uint32_t record : records) index_of_record_[record] = index;
    if (!is_empty(index)) ++statistics_.meshes_built;
    if (built.root() == nullptr) return true;

    const Encoder encoder(context, built.root(), kNoLimit);
    const std::optional<std::size_t> place = room_for(encoder.bytes() / kUnitBytes);
    if (!place) return false;
    const Link link = encoder.encode(tree_.block.data(), *place, records);
    const NodeSlot subtree = make_slot({built.root()->bounds(), built.range(), link});
    Insertion insertion(tree_.block.data(), tree_.space, tree_.root);
    insertion.insert(subtree);
    const std::size_t pushed = tree_.counts.depth + (insertion.pushes_down() ? 1 : 0);
    tree_.root = insertion.root();
    tree_.counts.add(insertion.change());
    tree_.counts.add(encoder.counts());
    tree_.counts.depth = std::max(pushed, insertion.levels() + encoder.counts().depth);
    tree_.temporal_splits += built.temporal_splits();
    tree_.usual_area += encoder.counts().expected_area + expected_area(built.root()->bounds(), built.range());
    peak_bytes_ = std::max(peak_bytes_, tree_.bytes() + context.memory.peak());
    return tree_.counts.depth <= kMaxLevels;
  }

  /// Room for a subtree of `units`, and for its insertion; none where that is too much.
  std::optional<std::size_t> room_for(std::size_t units) {
    const std::size_t end = tree_.space.end();
    if (end + units + kInsertionUnits > tree_.space.capacity()) {
      const std::size_t needed = end + units + kInsertionUnits;
      const std::size_t capacity = std::min(needed + end / kSpareShare, kMaxUnits);
      if (needed > capacity) return std::nullopt;
      peak_bytes_ = std::max(peak_bytes_, tree_.bytes() + capacity * kUnitBytes);
      tree_.block.grow(callbacks_, capacity * kUnitBytes, end * kUnitBytes);
      tree_.space.grow_to(capacity);
    }
    return tree_.space.take(units);
  }

  void refresh() {
    for (std::uint32_t record = 0; record < tree_.meshes.size(); ++record) {
      const std::size_t index = index_of_record_[record];
      if (index != kNowhere) tree_.meshes.refresh(record, meshes_[index], index);
    }
  }

  /// Whether rays are about as fast as in a tree built anew, and memory is not wasted.
  bool is_good() {
    statistics_.expected_cost = tree_.usual_area > 0.0 ? tree_.counts.expected_area / tree_.usual_area : 1.0;
    tree_.usual_area = std::min(tree_.usual_area, tree_.counts.expected_area);
    peak_bytes_ = std::max(peak_bytes_, tree_.bytes());
    const UnitSpace& space = tree_.space;
    const auto unused = static_cast<double>(space.unused() + space.capacity() - space.end());
    const bool has_waste = unused > kMostUnused * static_cast<double>(space.capacity()) + kInsertionUnits;
    // What is left of one that had far more: nothing is known of what it would be.
    if (tree_.usual_area <= 0.0 && tree_.counts.expected_area > 0.0) return false;
    return statistics_.expected_cost <= kMostArea && !has_waste && tree_.bytes() <= tree_.settings.max_bytes;
  }

  StoredTree& tree_;
  std::span<const MeshView> meshes_;
  std::span<const MeshUpdate> updates_;
  const BuildCallbacks& callbacks_;
  BuildCallbacks inner_;
  std::mutex report_;
  double reported_ = 0.0, done_ = 0.0, share_ = 1.0;
  bool is_cancelled_ = false;
  std::vector<std::size_t> index_of_record_;  ///< in the meshes as they are now
  std::vector<RecordEdit::Fate> fates_;
  std::vector<std::optional<BuildMesh>> moved_;  ///< of each record
  std::vector<std::size_t> new_meshes_;
  UpdateStatistics statistics_;
  std::size_t peak_bytes_ = 0;
};

}  // namespace

std::optional<UpdateStatistics> update_tree(StoredTree& tree, std::span<const MeshView> meshes,
                                            std::span<const MeshUpdate> updates,
                                            const BuildCallbacks& callbacks, std::size_t& peak_bytes) {
  Update update(tree, meshes, updates, callbacks);
  if (!update.run()) return std::nullopt;
  peak_bytes = update.peak_bytes();
  return update.statistics();
}

}  // namespace stbvh
