/// Building an STBVH over meshes, and asking it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "stbvh/isa.h"
#include "stbvh/mesh_view.h"
#include "stbvh/node_visitor.h"

namespace stbvh {

/// Where the final nodes and leaves live, and who is told of the build's progress and memory.
struct BuildCallbacks {
  /// Returns `bytes` of memory aligned to 64, or throws; null: operator new.
  std::function<void*(std::size_t bytes)> allocate;
  /// Gives back what `allocate` returned; called by the structure's destructor.
  std::function<void(void* data, std::size_t bytes)> release;
  /// Told how many bytes of temporary memory the build takes (+) or gives back (-); may be called from any
  /// worker thread. Returns false to cancel the build; the bytes it refuses are not taken, and not given
  /// back.
  std::function<bool(std::ptrdiff_t bytes)> temporary_memory;
  /// Told the fraction done, 0 to 1, never decreasing, one call at a time. Returns false to cancel the build.
  std::function<bool(double fraction)> progress;
  /// Told of each mesh, one after another, the exact boxes of its valid triangles at the steps that were kept
  /// (empty boxes without any), and the times of these; without times they are equidistant. Where parts of a
  /// mesh keep different steps, it is called for each part.
  std::function<void(std::size_t mesh, std::vector<Box3f> steps, std::span<const float> step_times)>
      step_bounds = nullptr;
};

/// How rays are tested against boxes and triangles.
enum class Precision {
  /// A triangle is hit or missed exactly as its interpolated vertices say, edges of neighbours leave no gap,
  /// and no box hides what the triangle test accepts (Woop, Benthin, Wald 2013; docs/accuracy.md).
  kWatertight,
  /// Moeller-Trumbore (1997) in float and unpadded slabs, as renderers commonly do: rays that meet an edge or
  /// a vertex may slip through, and far from the origin hits are less exact.
  kFast,
};

/// Takes steps as they are given.
inline constexpr float kKeepAllSteps = -1.0f;

inline constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

struct BuildSettings {
  /// Bytes that the structure may take. Where it would take more, memory is spent where rays profit most from
  /// it: time is split less often, and leaves that rays seldom meet read the caller's buffers.
  std::size_t max_bytes = kNoLimit;
  /// Bytes that structure and temporary memory of the build together may take; which tree is built then
  /// depends on the number of threads.
  std::size_t max_peak_bytes = kNoLimit;
  /// The tree does not depend on it.
  Precision precision = Precision::kWatertight;
  /// How far a vertex may be from where its mesh says at any time, scene units: of each mesh, and of parts of
  /// it that move otherwise than the rest, only the steps are kept that this takes. 0: within rounding, so
  /// that what stands still is static, and straight motion has two steps. Or kKeepAllSteps.
  float tolerance = 0.0f;

  bool operator==(const BuildSettings&) const = default;
};

/// Thrown by build() when a callback returned false; nothing is left behind.
struct BuildCancelled : std::runtime_error {
  BuildCancelled() : std::runtime_error("build cancelled") {}
};

/// Thrown by build() for a mesh description that cannot be read (no steps, too many, buffers missing, a time
/// range that is empty or not finite).
struct InvalidMesh : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Thrown by build() where even the smallest structure takes more than BuildSettings allows.
struct MemoryLimit : std::runtime_error {
  MemoryLimit(const std::string& message, std::size_t needed)
      : std::runtime_error(message), needed_bytes(needed) {}
  std::size_t needed_bytes;  ///< of the structure; 0: it is the peak that is too small
};

struct BuildStatistics {
  std::size_t triangles = 0;           ///< valid, and alive at some time in [0, 1]
  std::size_t invalid_triangles = 0;   ///< left out: index out of range, or a vertex not finite in some step
  std::size_t primitive_segments = 0;  ///< sum over valid triangles of max(segments kept, 1)
  std::size_t structure_bytes = 0;     ///< nodes, leaves and mesh table
  std::size_t wanted_bytes = 0;        ///< that it would take if it were not limited, about
  std::size_t peak_bytes = 0;          ///< structure and temporary memory of the build at their largest
  std::array<std::size_t, 3> nodes{};  ///< static, linear, spatial-temporal
  std::array<std::size_t, 3> node_children{};
  std::size_t inline_leaves = 0;
  std::size_t indexed_leaves = 0;
  std::size_t leaf_triangles = 0;  ///< triangles in leaves, counted once for each leaf that holds them
  std::size_t leaf_bytes = 0;
  std::size_t temporal_splits = 0;
  std::size_t steps_given = 0;  ///< of all meshes
  std::size_t steps_kept = 0;   ///< by any part of a mesh
  double max_deviation = 0.0;   ///< of any vertex at any time, for the steps left out; scene units
  std::size_t depth = 0;        ///< nodes from the root to the deepest leaf
};

/// A ray in the conventions of Embree, its members in the order of RTCRay: hits with tnear < t <= tfar,
/// direction not normalised.
struct Ray {
  Vec3f origin;
  float tnear;
  Vec3f direction;
  float time;
  float tfar;
  std::uint32_t mask = 0xFFFFFFFFu;  ///< meets every mesh whose own mask is not 0
};

inline constexpr std::uint32_t kInvalidId = 0xFFFFFFFFu;

/// Hit data as Embree's triangles give it: point = (1-u-v) p_0 + u p_1 + v p_2 of the triangle interpolated
/// at the ray's time, normal = cross(p_1 - p_0, p_2 - p_0), not normalised.
struct Hit {
  float t;
  float u, v;
  Vec3f normal;
  std::uint32_t prim_id;
  std::uint32_t geom_id;  ///< of the mesh view; kInvalidId: no hit
  std::uint32_t mesh;     ///< index of the mesh in the span given to build()
};

/// Asked for each candidate hit (nearest found so far, not yet final); false rejects it and traversal goes
/// on.
struct HitFilter {
  bool (*accept)(void* user, const Ray& ray, const Hit& candidate) = nullptr;
  void* user = nullptr;
};

/// Many rays for one query, `stride` bytes apart, and who is told of those that hit something: `report`, with
/// the ray where it stands and its closest hit (of any-hit queries `hit` is not initialised), in no order.
/// The ray is not read afterwards.
struct RayBatch {
  const void* rays;
  std::size_t stride;
  std::size_t count;
  void (*report)(void* user, const Ray& ray, const Hit& hit);  ///< null: nobody
  void* user;
  const HitFilter* filter = nullptr;
};

/// What a traversal met, for reports; counted in a template of its own. Leaves are those whose triangles were
/// tested: not those that the ray's mask or time rules out.
struct TraversalCounters {
  std::uint64_t nodes = 0;
  std::uint64_t leaves = 0;
  std::uint64_t triangle_tests = 0;
};

struct StoredTree;

/// How a mesh differs from the one that a structure holds.
enum class MeshChange : std::uint8_t {
  kNothing,    ///< in its mask and geom_id at most; its buffers may lie elsewhere
  kPositions,  ///< in positions too; triangles, number of steps and times are the same
  kAll,
};

inline constexpr std::size_t kNewMesh = std::numeric_limits<std::size_t>::max();

/// Where a mesh comes from.
struct MeshUpdate {
  std::size_t was = kNewMesh;  ///< its index in the meshes of the last build() or update()
  MeshChange change = MeshChange::kAll;
};

/// What an update did.
struct UpdateStatistics {
  std::size_t meshes_refitted = 0;  ///< kept their leaves, with other positions
  std::size_t meshes_built = 0;     ///< each as a subtree of its own
  std::size_t meshes_removed = 0;   ///< or have no triangles now
  std::size_t leaves_refitted = 0;
  /// What rays have to do, in surface area (MBSAH), to what they would have in a tree built anew, as far as
  /// that is known: 1 of a tree just built.
  double expected_cost = 1.0;
};

/// An STBVH. Queries may run on any number of threads at once, but not beside update().
class Structure {
 public:
  /// Builds over `meshes` (Woop et al. 2017, section 3). The tree is the same for any number of threads.
  /// Throws InvalidMesh, BuildCancelled, MemoryLimit, std::bad_alloc, std::length_error (a structure above 32
  /// GiB), and what the callbacks throw.
  static std::unique_ptr<Structure> build(std::span<const MeshView> meshes,
                                          const BuildSettings& settings = {},
                                          const BuildCallbacks& callbacks = {});
  virtual ~Structure() = default;

  /// Makes it that of `meshes`, and does the work of the changes only: refits the leaves of meshes whose
  /// positions have changed, takes out leaves of those that are gone, builds those that are new or differ
  /// otherwise by themselves, and hangs them in. Rays are answered as by a structure built anew. One update
  /// for each mesh; a mesh of before that none of them names is gone. The settings are those of the build;
  /// callbacks.step_bounds is called for refitted and built meshes only.
  ///
  /// Throws std::invalid_argument unless there are as many updates as meshes, and what build() throws.
  ///
  /// None: most has changed, rays would have more than 6 % more to do than in a tree built anew, by
  /// expected area, more than a quarter of the memory would be unused, or a limit does not allow it. Then,
  /// and after exceptions (as build() throws them), it may only be destroyed.
  virtual std::optional<UpdateStatistics> update(std::span<const MeshView> meshes,
                                                 std::span<const MeshUpdate> updates,
                                                 const BuildCallbacks& callbacks = {}) = 0;

  /// Closest hit in (tnear, tfar]; false, and `hit` untouched, if there is none. A ray that is not finite (or
  /// of zero direction, from a coordinate beyond 2^126, or at a time outside [0, 1]) hits nothing.
  virtual bool intersect(const Ray& ray, Hit& hit, const HitFilter* filter = nullptr) const = 0;
  /// Whether anything is hit in (tnear, tfar].
  virtual bool occluded(const Ray& ray, const HitFilter* filter = nullptr) const = 0;

  /// The same for many rays on the calling thread, with the same bits. Where memory is waited for, several
  /// are in flight at once: others go on while that of one is on its way (docs/performance.md). They need not
  /// be alike, nor sorted. `hits` and `occluded` have the length of `rays`; without a hit geom_id is
  /// kInvalidId.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits, const HitFilter* filter = nullptr) const;
  void occluded(std::span<const Ray> rays, std::span<bool> occluded, const HitFilter* filter = nullptr) const;
  virtual void intersect(const RayBatch& batch) const = 0;
  virtual void occluded(const RayBatch& batch) const = 0;

  /// As above on one instruction set (one of available_isas()), for tests.
  virtual bool intersect_on(Isa isa, const Ray& ray, Hit& hit, const HitFilter* filter = nullptr) const = 0;
  virtual bool occluded_on(Isa isa, const Ray& ray, const HitFilter* filter = nullptr) const = 0;
  /// Always in flight.
  virtual void intersect_on(Isa isa, const RayBatch& batch) const = 0;
  virtual void occluded_on(Isa isa, const RayBatch& batch) const = 0;

  /// As above, adding to `counters`.
  virtual bool intersect_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const = 0;
  virtual bool occluded_counted(const Ray& ray, TraversalCounters& counters) const = 0;

  /// Bounds that hold at `time` in [0, 1] for everything in the structure.
  virtual Box3f bounds_at(float time) const = 0;

  virtual const BuildStatistics& statistics() const = 0;

  /// Shows all nodes and leaves to `visitor`, from the root down; none of an empty structure.
  virtual void visit_nodes(NodeVisitor& visitor) const = 0;

  /// The tree itself, for save_structure().
  virtual const StoredTree& stored() const = 0;

  /// Hash of all nodes and leaves: equal for equal trees that were built, and not changed since.
  virtual std::uint64_t tree_hash() const = 0;
};

}  // namespace stbvh
