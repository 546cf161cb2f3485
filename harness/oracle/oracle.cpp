#include "harness/oracle/oracle.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "harness/oracle/exact_triangle.h"

namespace stbvh::harness {
namespace {

bool can_hit(const Ray& ray, const Mesh& mesh) {
  return (ray.mask & mesh.mask) != 0 && mesh.triangle_count() > 0 && is_visible_at(mesh, ray.time);
}

/// What is known of a ray while triangles are tested, in any order.
class Collector {
 public:
  double limit() const { return answer_.certain_t_upper; }

  void add(const TriangleTest& test, OraclePrimitive primitive) {
    if (test.needed_exact) ++answer_.exact_triangles;
    if (!test.is_possible) return;
    answer_.is_possible = true;
    if (test.is_certain) {
      answer_.certain_t_upper = std::min(answer_.certain_t_upper, test.t_upper);
    } else {
      uncertain_.push_back(test);
    }
    if (test.is_inside) hits_.push_back({primitive, test});
  }

  OracleAnswer finish(const Scene& scene, const Ray& ray) {
    if (!hits_.empty()) find_nearest(scene, ray);
    const double tie_limit = std::min(answer_.t_upper, answer_.certain_t_upper);
    for (const auto& [primitive, test] : hits_) {
      if (test.t_lower <= tie_limit && test.t_upper >= answer_.t_lower) ++answer_.ties;
    }
    if (answer_.is_hit) --answer_.ties;  // itself
    for (const TriangleTest& test : uncertain_) {
      if (test.t_lower > answer_.certain_t_upper) continue;
      answer_.is_near_edge = true;
      answer_.edge_distance_ulps = std::min(answer_.edge_distance_ulps, std::abs(test.edge_distance_ulps()));
    }
    return std::move(answer_);
  }

 private:
  struct Hit {
    OraclePrimitive primitive;
    TriangleTest test;
  };

  void find_nearest(const Scene& scene, const Ray& ray) {
    double limit = std::numeric_limits<double>::infinity();
    for (const Hit& hit : hits_) limit = std::min(limit, hit.test.exact_t.upper);
    std::vector<Hit> candidates;
    std::copy_if(hits_.begin(), hits_.end(), std::back_inserter(candidates),
                 [&](const Hit& hit) { return hit.test.exact_t.lower <= limit; });
    std::sort(candidates.begin(), candidates.end(),
              [](const Hit& a, const Hit& b) { return a.primitive < b.primitive; });
    std::optional<ExactTriangle> least;
    const Hit* first = nullptr;
    for (const Hit& hit : candidates) {
      ExactTriangle exact(ray, scene.meshes[hit.primitive.geom_id], hit.primitive.prim_id);
      const int order = least ? exact.compare_t(*least) : -1;
      if (order < 0) {
        least = std::move(exact);
        first = &hit;
        answer_.nearest.clear();
      }
      if (order <= 0) answer_.nearest.push_back(hit.primitive);
      if (candidates.size() > 1 && !hit.test.needed_exact) ++answer_.exact_triangles;
    }
    answer_.is_hit = true;
    answer_.geom_id = first->primitive.geom_id;
    answer_.prim_id = first->primitive.prim_id;
    answer_.t = least->t();
    answer_.u = least->u();
    answer_.v = least->v();
    answer_.t_lower = first->test.t_lower;
    answer_.t_upper = first->test.t_upper;
    answer_.cosine = first->test.cosine;
    answer_.edge_distance_ulps = first->test.edge_distance_ulps();
  }

  OracleAnswer answer_;
  std::vector<Hit> hits_;
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
  if (!is_answerable(ray)) return {};
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
          collector.add(test_triangle(r, scene_.meshes[c.mesh], prim, c.motion), {c.mesh, prim});
        });
  }
  return collector.finish(scene_, ray);
}

std::vector<OracleAnswer> Oracle::answers(std::span<const Ray> rays) const {
  std::vector<OracleAnswer> answers(rays.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), 64), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) answers[i] = answer(rays[i]);
  });
  return answers;
}

std::optional<TriangleTest> Oracle::test(const Ray& ray, std::uint32_t geom_id, std::uint32_t prim_id) const {
  return test_primitive(scene_, ray, geom_id, prim_id);
}

std::optional<TriangleTest> test_primitive(const Scene& scene, const Ray& ray, std::uint32_t geom_id,
                                           std::uint32_t prim_id) {
  if (geom_id >= scene.meshes.size()) return std::nullopt;
  const Mesh& mesh = scene.meshes[geom_id];
  if (!is_answerable(ray) || prim_id >= mesh.triangle_count() || !can_hit(ray, mesh) ||
      !is_valid_triangle(mesh, prim_id)) {
    return std::nullopt;
  }
  return test_triangle(OracleRay(ray), mesh, prim_id, triangle_motion(mesh, ray.time));
}

}  // namespace stbvh::harness
