#include "ray_checks.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "require.h"

namespace stbvh::fuzz {

namespace {

/// The checks of one ray: what they share, and how they fail.
class RayCheck {
 public:
  RayCheck(const Structure& structure, const Ray& ray) : structure_(structure), ray_(ray) {}

  std::optional<Hit> trace(Isa isa, const HitFilter* filter = nullptr) const {
    Hit hit{};
    const bool found = structure_.intersect_on(isa, ray_, hit, filter);
    require_of(structure_.occluded_on(isa, ray_, filter) == found, isa, "occluded is what intersect is");
    return found ? std::optional(hit) : std::nullopt;
  }

  void check_range(Isa isa, const Hit& hit) const {
    require_of(std::isfinite(hit.t), isa, "t is finite");
    require_of(hit.t > ray_.tnear && hit.t <= ray_.tfar, isa, "t is in (tnear, tfar]");
  }

  void check_hit(Isa isa, const Hit& hit) const {
    check_range(isa, hit);
    constexpr float kOne = 1.0f + 0x1p-22f;
    require_of(hit.u >= 0.0f && hit.v >= 0.0f && hit.u + hit.v <= kOne, isa, "u, v are of the triangle");
  }

  void check_filters(Isa isa, const std::optional<Hit>& expected) const;
  void check_same(Isa isa, const std::optional<Hit>& expected, const std::optional<Hit>& hit) const;
  void check_default_isa(const std::optional<Hit>& expected) const;

  void require_of(bool condition, Isa isa, const char* what) const {
    if (!condition) fail(isa, what);
  }

 private:
  [[noreturn]] void fail(Isa isa, const char* what) const;

  const Structure& structure_;
  const Ray& ray_;
};

void RayCheck::fail(Isa isa, const char* what) const {
  const Ray& r = ray_;
  std::fprintf(stderr,
               "violated on %s: %s\norigin (%a, %a, %a) direction (%a, %a, %a)\n"
               "tnear %a tfar %a time %a mask %#x\n",
               isa_name(isa).data(), what, r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y,
               r.direction.z, r.tnear, r.tfar, r.time, r.mask);
  std::abort();
}

bool same_triangle(const Hit& a, const Hit& b) {
  return a.mesh == b.mesh && a.prim_id == b.prim_id && a.geom_id == b.geom_id;
}

bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

/// NaN is one value: which operand's payload survives is not defined.
bool same_normal(const Vec3f& a, const Vec3f& b) {
  const auto same = [](float x, float y) { return same_bits(x, y) || (std::isnan(x) && std::isnan(y)); };
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

bool same_hit(const Hit& a, const Hit& b) {
  return same_triangle(a, b) && same_bits(a.t, b.t) && same_bits(a.u, b.u) && same_bits(a.v, b.v) &&
         same_normal(a.normal, b.normal);
}

/// Bit for bit; where two triangles are hit at the same t, either will do, but the other must be hit as well.
void RayCheck::check_same(Isa isa, const std::optional<Hit>& expected, const std::optional<Hit>& hit) const {
  require_of(hit.has_value() == expected.has_value(), isa, "all instruction sets hit or miss");
  if (!hit) return;
  require_of(hit->t == expected->t, isa, "all instruction sets agree on t");
  std::optional<Hit> same = hit;
  if (!same_triangle(*hit, *expected)) {
    HitFilter only;
    only.accept = [](void* user, const Ray&, const Hit& candidate) {
      return same_triangle(candidate, *static_cast<const Hit*>(user));
    };
    Hit wanted = *expected;
    only.user = &wanted;
    same = trace(isa, &only);
    require_of(same && same->t == expected->t, isa, "another triangle only at the same t");
  }
  require_of(same_bits(same->t, expected->t) && same_bits(same->u, expected->u) &&
                 same_bits(same->v, expected->v) && same_normal(same->normal, expected->normal),
             isa, "all instruction sets agree bit for bit");
}

void RayCheck::check_filters(Isa isa, const std::optional<Hit>& expected) const {
  struct Seen {
    const RayCheck& check;
    Isa isa;
    bool accept;
    std::size_t count;
  };
  HitFilter filter;
  filter.accept = [](void* user, const Ray& ray, const Hit& candidate) {
    Seen& seen = *static_cast<Seen*>(user);
    ++seen.count;
    seen.check.check_hit(seen.isa, candidate);
    seen.check.require_of(&ray == &seen.check.ray_, seen.isa, "filters see the ray");
    return seen.accept;
  };
  Seen seen{*this, isa, false, 0};
  filter.user = &seen;
  require_of(!trace(isa, &filter), isa, "what is rejected is not hit");
  require_of((seen.count > 0) == expected.has_value(), isa, "a filter sees what may be hit");
  seen.accept = true;
  check_same(isa, expected, trace(isa, &filter));
}

void RayCheck::check_default_isa(const std::optional<Hit>& expected) const {
  const Isa isa = default_isa();
  Hit hit{};
  TraversalCounters counters;
  const bool found = structure_.intersect_counted(ray_, hit, counters);
  check_same(isa, expected, found ? std::optional(hit) : std::nullopt);
  require_of(!found || counters.triangle_tests > 0, isa, "a hit was tested");
  require_of(structure_.occluded_counted(ray_, counters) == found, isa,
             "occluded_counted is what occluded is");
  Hit untouched;
  std::memset(&untouched, 0x5A, sizeof untouched);
  const Hit before = untouched;
  require_of(structure_.intersect(ray_, untouched) == found && structure_.occluded(ray_) == found, isa,
             "the default instruction set is one of all");
  require_of(found || std::memcmp(&untouched, &before, sizeof before) == 0, isa,
             "a miss leaves the hit alone");
}

}  // namespace

void check_ray(const Structure& structure, const test::Unculled& unculled, const Ray& ray) {
  const RayCheck check(structure, ray);
  // The others are held against the fastest: the triangles one by one take most of the time.
  const Isa fastest = available_isas().back();
  const std::optional<Hit> hit = check.trace(fastest);
  double off_plane = 0;
  const std::optional<Hit> expected = unculled.intersect(fastest, ray, &off_plane);
  check.require_of(off_plane <= 1, fastest, "hits lie on the planes of their triangles, but for rounding");
  check.require_of(!expected || hit, fastest, "the tree finds what the triangle test accepts");
  check.require_of(!hit || expected, fastest, "the tree finds only what the triangle test accepts");
  check.require_of(!hit || hit->t == expected->t, fastest, "the tree finds the nearest hit");
  for (const Isa isa : available_isas()) {
    const std::optional<Hit> same = check.trace(isa);
    if (same) check.check_hit(isa, *same);
    check.check_same(isa, hit, same);
    check.check_filters(isa, hit);
  }
  check.check_default_isa(hit);
}

void check_batch(const Structure& structure, std::span<const Ray> rays) {
  struct Found {
    std::span<const Ray> rays;
    std::vector<int> times;
    std::vector<Hit> hits;

    std::size_t count(const Ray& ray) {
      const auto i = static_cast<std::size_t>(&ray - rays.data());
      require(++times[i] == 1, "a ray is reported once");
      return i;
    }
  };
  const auto closest_hit = [](void* user, const Ray& ray, const Hit& hit) {
    Found& found = *static_cast<Found*>(user);
    found.hits[found.count(ray)] = hit;
  };
  const auto any_hit = [](void* user, const Ray& ray, const Hit&) { static_cast<Found*>(user)->count(ray); };
  for (const Isa isa : available_isas()) {
    Found closest{rays, std::vector<int>(rays.size()), std::vector<Hit>(rays.size())}, any = closest;
    structure.intersect_on(isa, {rays.data(), sizeof(Ray), rays.size(), closest_hit, &closest});
    structure.occluded_on(isa, {rays.data(), sizeof(Ray), rays.size(), any_hit, &any});
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const RayCheck check(structure, rays[i]);
      Hit hit{};
      const bool found = structure.intersect_on(isa, rays[i], hit);
      check.require_of((closest.times[i] > 0) == found, isa, "in flight hit as alone");
      check.require_of(!found || same_hit(closest.hits[i], hit), isa, "in flight the same bits as alone");
      check.require_of((any.times[i] > 0) == structure.occluded_on(isa, rays[i]), isa,
                       "in flight occluded as alone");
    }
  }
}

void check_fast_ray(const Structure& fast, const Ray& ray) {
  const RayCheck check(fast, ray);
  for (const Isa isa : available_isas()) {
    Hit hit{};
    if (fast.intersect_on(isa, ray, hit)) check.check_range(isa, hit);
    static_cast<void>(fast.occluded_on(isa, ray));
    HitFilter none;
    none.accept = [](void*, const Ray&, const Hit&) { return false; };
    check.require_of(!fast.intersect_on(isa, ray, hit, &none) && !fast.occluded_on(isa, ray, &none), isa,
                     "what is rejected is not hit");
  }
}

}  // namespace stbvh::fuzz
