/// Bytes -> rays of any bit patterns into a few structures that are hard to bound, built once.
#include <memory>
#include <span>
#include <vector>

#include "flush_to_zero.h"
#include "hard_meshes.h"
#include "ray_bytes.h"
#include "ray_checks.h"

namespace stbvh::fuzz {
namespace {

constexpr std::size_t kMaxRays = 16;

using test::TestMesh;

/// Meshes of other step counts, each alive where the one before it ends.
std::vector<TestMesh> touching_grids() {
  constexpr std::size_t kSteps[] = {2, 3, 5, 7, 13, 16};
  std::vector<TestMesh> meshes;
  for (const std::size_t steps : kSteps) {
    const auto i = static_cast<std::uint32_t>(meshes.size());
    meshes.push_back(timed(test::ordinary(6, steps, 30 + i),
                           {static_cast<float>(i) / 6.0f, static_cast<float>(i + 1) / 6.0f}));
  }
  return meshes;
}

/// Triangles that are points, lines, or visible at one step only, and two that are the same.
TestMesh degenerate() {
  constexpr std::size_t kSteps = 4;
  TestMesh mesh;
  mesh.indices = {0, 0, 0, 0, 1, 1, 0, 1, 2, 2, 1, 0, 3, 4, 5, 5, 4, 3, 0, 4, 2};
  for (std::size_t step = 0; step < kSteps; ++step) {
    const float s = static_cast<float>(step);
    mesh.positions.push_back(
        {{0, 0, s}, {1, 0, s}, {0, 1, -s}, {s, s, s}, {2 * s, 2 * s, 2 * s}, {-s, 1, -s}});
  }
  return mesh;
}

/// A scene, its structure, and its triangles without a tree.
class Target {
 public:
  Target(std::vector<TestMesh> meshes, bool indexed) : meshes_(std::move(meshes)) {
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      meshes_[i].geom_id = static_cast<std::uint32_t>(i);
      meshes_[i].mask = i % 3 == 2 ? 0xFFFFu : 0xFFFFFFFFu;
      views_.push_back(meshes_[i].view());
    }
    BuildSettings settings = test::limited(views_, indexed ? 0.0f : 1.0f);
    structure_ = Structure::build(views_, settings);
    settings.precision = Precision::kFast;
    fast_ = Structure::build(views_, settings);
    unculled_ = std::make_unique<test::Unculled>(views_);
  }

  void check(std::span<const Ray> rays) const {
    check_batch(*structure_, rays);
    check_batch(*fast_, rays);
  }

  std::span<const MeshView> views() const { return views_; }
  void check(const Ray& ray) const {
    check_ray(*structure_, *unculled_, ray);
    check_fast_ray(*fast_, ray);
  }

 private:
  std::vector<TestMesh> meshes_;
  std::vector<MeshView> views_;
  std::unique_ptr<Structure> structure_, fast_;
  std::unique_ptr<test::Unculled> unculled_;
};

std::vector<Target> make_targets() {
  using namespace test;
  std::vector<Target> targets;
  for (const bool indexed : {false, true}) {
    const auto add = [&](std::vector<TestMesh> meshes) { targets.emplace_back(std::move(meshes), indexed); };
    add({sphere(3, 1), sphere(3, 9), soup(10, 5, 1)});
    add(touching_grids());
    add({needles(16, 9, 2), needles(8, 1, 3)});
    add({flat(20, 5, 4, true), flat(8, 1, 5, false), degenerate()});
    add({placed(ordinary(16, 129, 6), 1, 1e6f), timed(ordinary(8, 17, 7), {-1000.0f, 1000.0f})});
    add({placed(ordinary(16, 5, 8), 5e17f, 0), placed(ordinary(8, 1, 9), 1e-15f, 0)});
    add({placed(ordinary(16, 9, 10), 1e-20f, 0), placed(flat(8, 3, 11, false), 1e-20f, 0)});
  }
  return targets;
}

void run(ByteReader in) {
  static const std::vector<Target> targets = make_targets();
  const std::uint8_t flags = in.byte();
  const Target& target = targets[in.byte() % targets.size()];
  std::vector<Ray> rays;
  while (rays.size() < kMaxRays && !in.empty()) rays.push_back(take_ray(in, target.views()));
  const test::FlushToZero guard((flags & 1) != 0);
  for (const Ray& ray : rays) target.check(ray);
  target.check(rays);
}

}  // namespace
}  // namespace stbvh::fuzz

extern "C" __attribute__((visibility("default"))) int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                                                             std::size_t size) {
  stbvh::fuzz::run(stbvh::fuzz::ByteReader({data, size}));
  return 0;
}
