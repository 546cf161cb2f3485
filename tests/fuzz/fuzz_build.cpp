/// Bytes -> mesh descriptions, of which many cannot be read -> a structure, or the right refusal -> rays.
#include <tbb/global_control.h>

#include <atomic>
#include <memory>
#include <new>

#include "flush_to_zero.h"
#include "mesh_bytes.h"
#include "mesh_contract.h"
#include "ray_bytes.h"
#include "ray_checks.h"
#include "require.h"

namespace stbvh::fuzz {
namespace {

constexpr std::size_t kMaxMeshes = 5;
constexpr std::size_t kMaxRays = 16;

/// Keeps the books that the callbacks of a build allow to keep, and cancels it at the n-th call (0: never).
class Watch {
 public:
  explicit Watch(std::size_t cancel_at) : cancel_at_(cancel_at) {}
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  BuildCallbacks callbacks() {
    BuildCallbacks c;
    c.allocate = [this](std::size_t bytes) {
      blocks_ += bytes;
      return ::operator new (bytes, std::align_val_t{64});
    };
    c.release = [this](void* data, std::size_t bytes) {
      blocks_ -= bytes;
      ::operator delete (data, std::align_val_t{64});
    };
    c.temporary_memory = [this](std::ptrdiff_t bytes) {
      if (bytes > 0 && !goes_on()) return false;
      temporary_ += bytes;
      return true;
    };
    c.progress = [this](double fraction) {
      require(fraction >= fraction_ && fraction <= 1.0, "progress ascends from 0 to 1");
      fraction_ = fraction;
      return goes_on();
    };
    return c;
  }

  bool has_cancelled() const { return cancel_at_ > 0 && calls_ >= cancel_at_; }
  double fraction() const { return fraction_; }
  std::ptrdiff_t temporary_bytes() const { return temporary_; }
  std::size_t block_bytes() const { return blocks_; }

 private:
  bool goes_on() { return ++calls_ != cancel_at_; }

  std::size_t cancel_at_;
  std::atomic<std::size_t> calls_{0};
  std::atomic<std::ptrdiff_t> temporary_{0};
  std::atomic<std::size_t> blocks_{0};
  double fraction_ = 0.0;
};

/// Null where the descriptions are refused, which they are if and only if the contract says so.
std::unique_ptr<Structure> build(std::span<const MeshView> meshes, const BuildSettings& settings) {
  bool readable = true;
  for (const MeshView& mesh : meshes) readable = readable && is_readable(mesh);
  try {
    auto structure = Structure::build(meshes, settings);
    require(readable, "a mesh that cannot be read is refused");
    return structure;
  } catch (const InvalidMesh&) {
    require(!readable, "a mesh that can be read is not refused");
    return nullptr;
  }
}

/// Builds once more, with callbacks that may cancel: the same, or nothing, and no memory is left.
void build_watched(std::span<const MeshView> meshes, const BuildSettings& settings, std::size_t cancel_at,
                   const Structure& expected) {
  Watch watch(cancel_at);
  try {
    const auto structure = Structure::build(meshes, settings, watch.callbacks());
    require(structure->tree_hash() == expected.tree_hash(), "a build can be repeated");
    require(watch.has_cancelled() || watch.fraction() == 1.0, "progress ends at 1");
    check_statistics(meshes, settings.tolerance, structure->statistics());
  } catch (const BuildCancelled&) {
    require(watch.has_cancelled(), "a build ends early only if a callback says so");
  }
  require(watch.temporary_bytes() == 0, "temporary memory is given back");
  require(watch.block_bytes() == 0, "the structure's memory is released");
}

/// The valid triangles of the meshes, without anything above them.
std::unique_ptr<test::Unculled> make_unculled(std::span<const MeshView> meshes) {
  std::vector<MeshView> valid(meshes.begin(), meshes.end());
  std::vector<std::vector<std::array<std::uint32_t, 3>>> triangles;
  for (MeshView& mesh : valid) {
    triangles.push_back(valid_triangles(mesh));
    mesh.indices = triangles.back().data();
    mesh.triangle_count = triangles.back().size();
    mesh.index_stride = sizeof(std::array<std::uint32_t, 3>);
  }
  return std::make_unique<test::Unculled>(valid);
}

void run(ByteReader in) {
  const std::uint8_t flags = in.byte();
  const std::size_t cancel_at = in.byte();
  BuildSettings settings;
  const float share = (flags & 1) != 0 ? static_cast<float>(in.byte()) / 255.0f : 1.0f;
  std::vector<FuzzMesh> meshes;
  for (std::size_t count = in.below(kMaxMeshes + 1); count > 0; --count) meshes.push_back(take_mesh(in));
  std::vector<MeshView> views;
  for (const FuzzMesh& mesh : meshes) views.push_back(mesh.view);

  std::unique_ptr<Structure> structure, fast;
  std::unique_ptr<test::Unculled> unculled;
  {
    const test::FlushToZero guard((flags & 2) != 0);
    structure = build(views, settings);
    if (structure == nullptr) return;
    settings = test::limited(views, share);
    structure = build(views, settings);
    require(structure->statistics().structure_bytes <= settings.max_bytes, "no more memory than is allowed");
    check_statistics(views, settings.tolerance, structure->statistics());
    BuildSettings as_given = settings;
    as_given.tolerance = kKeepAllSteps;
    as_given.max_bytes = kNoLimit;
    check_statistics(views, as_given.tolerance, build(views, as_given)->statistics());
    if ((flags & 4) != 0) build_watched(views, settings, cancel_at, *structure);
    unculled = make_unculled(views);
    settings.precision = Precision::kFast;
    fast = build(views, settings);
  }
  for (std::size_t ray = 0; ray < kMaxRays && !in.empty(); ++ray) {
    const Ray any = take_ray(in, views);
    check_bounds(views, *structure, any.time);
    const test::FlushToZero guard((flags & 8) != 0);
    check_ray(*structure, *unculled, any);
    check_fast_ray(*fast, any);
  }
}

}  // namespace
}  // namespace stbvh::fuzz

extern "C" __attribute__((visibility("default"))) int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                                                             std::size_t size) {
  // One thread: what an input covers must not depend on who runs the tasks.
  static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  stbvh::fuzz::run(stbvh::fuzz::ByteReader({data, size}));
  return 0;
}
