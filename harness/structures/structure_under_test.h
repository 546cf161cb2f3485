/// A structure that the harness compares: built from a scene, asked with rays, weighed in bytes.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_editor.h"
#include "harness/structures/hit_record.h"
#include "harness/structures/outline.h"

namespace stbvh::harness {

struct BuildRecord {
  double build_s = 0;                 ///< time of building, buffers already in memory
  std::size_t structure_bytes = 0;    ///< after the build
  std::size_t monitor_bytes = 0;      ///< after the build, as the Embree device counts; 0 without a device
  std::size_t peak_bytes = 0;         ///< largest during the build, as the structure's own monitor counts
  std::ptrdiff_t resident_bytes = 0;  ///< growth of the process's resident memory over the build
  std::size_t wanted_bytes = 0;       ///< of the structure if it were not limited, about; ours alone
  std::size_t steps_kept = 0;         ///< of all meshes together; all that they have but for ours
  double max_deviation = 0;           ///< of a vertex at any time for those left out, scene units
};

/// Thrown where a structure cannot keep to Scene::max_bytes; what() says what it would need, as the rest of a
/// sentence.
struct OverLimit : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Told the fraction done, 0 to 1, from any thread, also from several at once; false cancels the build.
using BuildProgress = std::function<bool(double fraction)>;

class StructureUnderTest {
 public:
  virtual ~StructureUnderTest() = default;

  virtual const BuildRecord& build_record() const = 0;

  /// For structures that is_updatable(): makes it that of `scene`, the one that it was built over, in which
  /// `edits` were made since. The record is that of the build.
  virtual void update(const Scene& scene, std::span<const MeshEdit> edits) {
    static_cast<void>(scene), static_cast<void>(edits);
  }

  /// Traces each of `rays` once, on the calling thread; `hits` has the same length.
  virtual void intersect(std::span<const Ray> rays, std::span<HitRecord> hits) const = 0;
  virtual void occluded(std::span<const Ray> rays, std::span<HitRecord> hits) const = 0;

  /// Closest hit of one ray, for pictures; false, and `hit` untouched, if there is none. geom_id and mesh are
  /// the index of the mesh in the scene. May run on any number of threads at once.
  virtual bool intersect_one(const Ray& ray, Hit& hit) const = 0;
  virtual bool occluded_one(const Ray& ray) const = 0;

  /// Whether intersect_one_counted counts: what the structure meets can be asked of our own kernels only.
  virtual bool has_counters() const { return false; }
  /// As intersect_one, adding to `counters` where the structure has them.
  virtual bool intersect_one_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const {
    static_cast<void>(counters);
    return intersect_one(ray, hit);
  }
  /// The bounds that rays of `time` meet `level` nodes below the root, leaves above that level included;
  /// empty where the structure cannot show them.
  virtual std::vector<Outline> outlines_at(float time, std::size_t level) const {
    static_cast<void>(time), static_cast<void>(level);
    return {};
  }
  /// The tree itself, of our own kernels where nothing stands between; else null.
  virtual const Structure* tree() const { return nullptr; }
};

/// Names of all structures, in the order in which tables print them.
std::vector<std::string_view> structure_names();

/// Names of the methods that came before ours, and of ours without its ideas (docs/gallery.md): structures
/// too, but not among structure_names().
std::vector<std::string_view> gallery_names();

bool is_in_gallery(std::string_view name);

/// What the structure `name` is, in one line. Throws std::invalid_argument for an unknown name.
std::string_view structure_description(std::string_view name);

/// Whether that structure promises the exact answer within rounding: ours do, but for the fast precision and
/// where Embree answers a part of the rays.
bool is_exact(std::string_view name);

/// Whether that structure is traversed without vector instructions.
bool is_scalar(std::string_view name);

/// Whether that structure keeps to Scene::max_bytes.
bool is_limitable(std::string_view name);

/// Whether StructureUnderTest::update() of that structure does anything.
bool is_updatable(std::string_view name);

/// Why the structure `name` cannot be built over `scene`, as the rest of a sentence; empty if it can.
std::string obstacle(std::string_view name, const Scene& scene);

/// Builds the structure `name` over `scene`, which must outlive it, with `threads` build threads (0: all).
/// Throws std::invalid_argument for an unknown name, std::runtime_error where there is an obstacle,
/// OverLimit, BuildCancelled where `progress` returned false.
std::unique_ptr<StructureUnderTest> build_structure(std::string_view name, const Scene& scene,
                                                    unsigned threads, const BuildProgress& progress = {});

}  // namespace stbvh::harness
