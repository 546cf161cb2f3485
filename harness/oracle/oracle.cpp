#include "harness/oracle/oracle.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace stbvh::harness {
namespace {

bool can_hit(const Ray& ray, const Mesh& mesh) {
  return (ray.mask & mesh.mask) != 0 && mesh.triangle_count() > 0 && is_visible_at(mesh, ray.time);
}

/// What is known of a ray while triangles are tested, in any order.
class Collector {
 public:
  double limit() const { return answer_.certain_t_upper; }

  void add(const TriangleTest& test, std::uint32_t geom_id, std::uint32_t prim_id) {
    if (!test.is_possible) return;
    answer_.is_possible = true;
    if (test.is_certain) {
      answer_.certain_t_upper = std::min(answer_.certain_t_upper, test.t_upper);
    } else {
      uncertain_.push_back(test);
    }
    if (!test.is_inside) return;
    hits_.push_back(test);
    const bool is_nearer =
        !answer_.is_hit || test.t < answer_.t ||
        (test.t == answer_.t && std::pair(geom_id, prim_id) < std::pair(answer_.geom_id, answer_.prim_id));
    if (!is_nearer) return;
    answer_.is_hit = true;
    answer_.t = test.t;
    answer_.t_lower = test.t_lower;
    answer_.t_upper = test.t_upper;
    answer_.geom_id = geom_id;
    answer_.prim_id = prim_id;
    answer_.edge_distance_ulps = test.edge_distance_ulps();
  }

  OracleAnswer finish() {
    const double tie_limit = std::min(answer_.t_upper, answer_.certain_t_upper);
    for (const TriangleTest& test : hits_) {
      if (test.t_lower <= tie_limit && test.t_upper >= answer_.t_lower) ++answer_.ties;
    }
    if (answer_.is_hit) --answer_.ties;  // itself
    for (const TriangleTest& test : uncertain_) {
      if (test.t_lower > answer_.certain_t_upper) continue;
      answer_.is_near_edge = true;
      answer_.edge_distance_ulps = std::min(answer_.edge_distance_ulps, std::abs(test.edge_distance_ulps()));
    }
    return answer_;
  }

 private:
  OracleAnswer answer_;
  std::vector<TriangleTest> hits_;
  std::vector<TriangleTest> uncertain_;
};

}  // namespace

Oracle::Oracle(const Scene& scene, Cull cull) : scene_(scene) {
  culls_.reserve(scene.meshes.size());
  for (const Mesh& mesh : scene.meshes) culls_.emplace_back(mesh, cull == Cull::kBoxes);
}

OracleAnswer Oracle::answer(const Ray& ray) const {
  struct Candidate {
    double t;
    std::uint32_t mesh;
    TriangleMotion motion;
  };
  const OracleRay r(ray);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < scene_.meshes.size(); ++i) {
    const Mesh& mesh = scene_.meshes[i];
    if (!can_hit(ray, mesh)) continue;
    const TriangleMotion motion = triangle_motion(mesh, ray.time);
    const double t = culls_[i].nearest(r, motion);
    if (t < MeshCull::kPasses) {
      candidates.push_back({t, static_cast<std::uint32_t>(i), motion});
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.t < b.t; });
  Collector collector;
  for (const Candidate& c : candidates) {
    culls_[c.mesh].visit(
        r, c.motion, [&] { return collector.limit(); },
        [&](std::uint32_t prim) {
          collector.add(test_triangle(r, scene_.meshes[c.mesh], prim, c.motion), c.mesh, prim);
        });
  }
  return collector.finish();
}

std::vector<OracleAnswer> Oracle::answers(std::span<const Ray> rays) const {
  std::vector<OracleAnswer> answers(rays.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), 64), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) answers[i] = answer(rays[i]);
  });
  return answers;
}

std::optional<TriangleTest> Oracle::test(const Ray& ray, std::uint32_t geom_id, std::uint32_t prim_id) const {
  if (geom_id >= scene_.meshes.size()) return std::nullopt;
  const Mesh& mesh = scene_.meshes[geom_id];
  if (prim_id >= mesh.triangle_count() || !can_hit(ray, mesh) || !is_valid_triangle(mesh, prim_id)) {
    return std::nullopt;
  }
  return test_triangle(OracleRay(ray), mesh, prim_id, triangle_motion(mesh, ray.time));
}

}  // namespace stbvh::harness
