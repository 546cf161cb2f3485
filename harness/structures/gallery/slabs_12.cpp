/// `slabs-12`: each child between twelve pairs of parallel planes in space and time, on our builder (after
/// Glassner 1988, spacetime ray tracing for animation).
///
/// Stored: nodes of eight children (slabs_12_nodes.inl) with their extents along the four axes of space-time
/// and the eight diagonals of its hypercube. At a fixed time the slab of a diagonal is a slab in space that
/// moves at a speed which is the same everywhere. Built: by our builder, whose object and temporal splits
/// stand in for Glassner's adaptive subdivision of space-time; the bounds of what bounds its triangles are
/// unions, which slabs of fixed directions join without loss. Traversed: a ray's place and speed along all
/// normals are computed once.
///
/// The full paper was not to be had; inferred: which twelve directions, and how time is measured against
/// space. Leaves hold what ours hold; where Glassner subdivides space-time without overlap, our nodes may
/// overlap in space.
#include <algorithm>
#include <cmath>

#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/gallery_tree.h"
#include "harness/structures/gallery/projection.h"
#include "harness/structures/gallery/slabs_12_nodes.inl"
#include "harness/structures/gallery/wide_nodes.h"

namespace stbvh::harness::gallery {
namespace {

/// How fast vertices move, in the mean over all that move: the speed at which the slabs of diagonals follow
/// them. Nodes that a uniform ray visits, at this speed and at one of the scene's extent in a shutter: 8.4
/// and 9.5 in train, 7.3 and 10.5 in dancer, 10.0 and 11.9 in barbershop, 6.9 and 9.2 in barbarian-rotate.
/// Half the mean and twice the mean are within 6 % of it, now better, now worse.
float mean_speed(const BuildContext& context) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < context.meshes.size(); ++i) {
    const BuildMesh& mesh = context.meshes[i];
    if (mesh.is_static()) continue;
    double way = 0;
    for (const Meshlet& meshlet : context.meshlets[i].meshlets()) {
      for (const std::uint32_t vertex : meshlet.used_vertices()) {
        for (std::size_t step = 0; step < mesh.segments(); ++step) {
          const Vec3f a = mesh.position(step, vertex);
          const Vec3f b = mesh.position(step + 1, vertex);
          way += std::hypot(double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z);
        }
      }
      count += meshlet.vertex_count;
    }
    sum += way / static_cast<double>(mesh.grid().length);
  }
  constexpr double kFastest = 1e30;  // stays finite in what a ray computes
  return count > 0 ? static_cast<float>(std::min(sum / count, kFastest)) : 0.0f;
}

class Slabs12Method {
 public:
  struct Bounds {
    std::array<Interval, kSpaceSlabs> slabs;
    ClosedTimeRange range;
  };

  Slabs12Method(const BuildContext& context, const Slabs12Scene& scene)
      : context_(context), centre_{scene.centre[0], scene.centre[1], scene.centre[2]}, scale_(scene.scale) {
    for (std::size_t i = 0; i < kSlabDirections; ++i)
      std::copy_n(kSlabDirection[i], 3, directions_[i].begin());
  }

  Bounds of_leaf(const BinaryLeaf& leaf) const {
    const BuildMesh& mesh = context_.meshes[leaf.mesh];
    const MotionSamples samples(mesh, leaf.range);
    ProjectedMotion<kSlabDirections> motion(mesh, samples, centre_, directions_);
    motion.extend(*leaf.meshlet);
    const auto reach = motion.padded();
    Bounds bounds{{}, mesh.alive(leaf.range)};
    const auto extend = [&](const std::array<Interval, kSlabDirections>& at_time, double time) {
      for (int slab = 0; slab < kSpaceSlabs; ++slab) {
        const Interval& place = at_time[static_cast<std::size_t>(direction_of_slab(slab))];
        const double shift = time_sign_of_slab(slab) * double{scale_} * time;
        bounds.slabs[static_cast<std::size_t>(slab)].extend({place.lower + shift, place.upper + shift});
      }
    };
    // At both ends, and at the steps in between: planes and vertices move linearly.
    extend(reach.front(), bounds.range.begin);
    for (std::size_t i = 1; i + 1 < reach.size(); ++i)
      extend(reach[i], mesh.time_of_step(samples.samples[i].segment));
    extend(reach.back(), bounds.range.last);
    return bounds;
  }

  Bounds joined(std::span<const Bounds* const> children) const {
    Bounds all = *children.front();
    for (const Bounds* child : children.subspan(1)) {
      for (std::size_t slab = 0; slab < kSpaceSlabs; ++slab) all.slabs[slab].extend(child->slabs[slab]);
      all.range.begin = std::min(all.range.begin, child->range.begin);
      all.range.last = std::max(all.range.last, child->range.last);
    }
    return all;
  }

  std::size_t bytes(std::span<const Bounds* const>) const { return sizeof(Slabs12Node); }

  void write(std::span<const Bounds* const> children, std::span<const Link> links, std::byte* out) const {
    constexpr float inf = std::numeric_limits<float>::infinity();
    auto& node = *new (out) Slabs12Node{};
    for (auto& [lower, upper] : node.planes) {
      std::fill_n(lower, kWidth, inf);
      std::fill_n(upper, kWidth, -inf);
    }
    std::copy(links.begin(), links.end(), node.children);
    for (std::size_t child = 0; child < children.size(); ++child) {
      const Bounds& bounds = *children[child];
      for (std::size_t slab = 0; slab < kSpaceSlabs; ++slab) {
        node.planes[slab][0][child] = rounded_down(bounds.slabs[slab].lower);
        node.planes[slab][1][child] = rounded_up(bounds.slabs[slab].upper);
      }
      node.time_begin[child] = bounds.range.begin;
      node.time_last[child] = bounds.range.last;
    }
  }

 private:
  const BuildContext& context_;
  Point centre_;
  float scale_;
  std::array<Direction, kSlabDirections> directions_;
};

/// Where three planes meet; nothing where two of them are parallel, or all of them to one line.
std::optional<Point> meeting_point(const Point (&normals)[3], const double (&places)[3]) {
  const auto cross = [](const Point& a, const Point& b) {
    return Point{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Point crosses[3] = {cross(normals[1], normals[2]), cross(normals[2], normals[0]),
                            cross(normals[0], normals[1])};
  double determinant = 0;
  for (std::size_t i = 0; i < 3; ++i) determinant += normals[0][i] * crosses[0][i];
  if (determinant == 0) return std::nullopt;  // of small integers: exact
  Point p{};
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = (places[0] * crosses[0][i] + places[1] * crosses[1][i] + places[2] * crosses[2][i]) / determinant;
  return p;
}

/// The corners of what lies within all slabs in space, relative to their centre: of all points where three
/// planes meet, those beyond no plane.
std::vector<Point> corners_of(const std::array<Interval, kSlabDirections>& slabs) {
  const auto normal = [](std::size_t i) {
    const auto& n = kSlabDirection[i];
    return Point{n[0], n[1], n[2]};
  };
  double size = 0;
  for (const Interval& slab : slabs) size = std::max({size, std::fabs(slab.lower), std::fabs(slab.upper)});
  const auto is_within = [&](const Point& p) {
    for (std::size_t i = 0; i < kSlabDirections; ++i) {
      const Point n = normal(i);
      const double place = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
      if (place < slabs[i].lower - 1e-12 * size || place > slabs[i].upper + 1e-12 * size) return false;
    }
    return true;
  };
  std::vector<Point> corners;
  const auto add = [&](const std::array<std::size_t, 3>& which) {
    for (unsigned sides = 0; sides < 8; ++sides) {
      double places[3];
      for (std::size_t i = 0; i < 3; ++i)
        places[i] = (sides >> i & 1u) != 0 ? slabs[which[i]].upper : slabs[which[i]].lower;
      const auto p = meeting_point({normal(which[0]), normal(which[1]), normal(which[2])}, places);
      if (p && is_within(*p)) corners.push_back(*p);
    }
  };
  for (std::size_t i = 0; i < kSlabDirections; ++i) {
    for (std::size_t j = i + 1; j < kSlabDirections; ++j) {
      for (std::size_t k = j + 1; k < kSlabDirections; ++k) add({i, j, k});
    }
  }
  return corners;
}

std::vector<OutlinedChild> slabs_12_children_at(const GalleryView& view, Link link, float time) {
  const auto& node = *reinterpret_cast<const Slabs12Node*>(view.data + unit_of(link) * kUnitBytes);
  const auto& scene = *static_cast<const Slabs12Scene*>(view.method);
  std::vector<OutlinedChild> children;
  for (std::size_t child = 0; child < kWidth; ++child) {
    if (node.planes[0][0][child] > node.planes[0][1][child]) continue;  // empty
    if (!(time >= node.time_begin[child] && time <= node.time_last[child])) continue;
    constexpr double inf = std::numeric_limits<double>::infinity();
    std::array<Interval, kSlabDirections> slabs;
    slabs.fill({-inf, inf});
    for (int slab = 0; slab < kSpaceSlabs; ++slab) {
      const auto& [lower, upper] = node.planes[slab];
      const double shift = time_sign_of_slab(slab) * double{scene.scale} * time;
      Interval& at_time = slabs[static_cast<std::size_t>(direction_of_slab(slab))];
      at_time = {std::max(at_time.lower, lower[child] - shift),
                 std::min(at_time.upper, upper[child] - shift)};
    }
    Outline corners;
    for (const Point& p : corners_of(slabs)) {
      const auto place = [&](std::size_t i) { return static_cast<float>(p[i] + scene.centre[i]); };
      corners.push_back({place(0), place(1), place(2)});
    }
    children.push_back({node.children[child], std::move(corners)});
  }
  return children;
}

WrittenTree write_slabs_12(BuildContext& context, BinaryNode& root) {
  const Vec3f c = centre_of(root);
  const auto shared = std::make_shared<Slabs12Scene>(Slabs12Scene{{c.x, c.y, c.z}, mean_speed(context)});
  const Slabs12Method method(context, *shared);
  return write_wide_nodes(context, method, root, method_kernels().slabs_12, slabs_12_children_at, shared,
                          sizeof *shared);
}

}  // namespace

StructurePtr build_slabs_12(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  GalleryTree::Method method;
  method.make_builder = [](BuildContext& context) { return std::make_unique<TopDown>(context); };
  method.write = write_slabs_12;
  return std::make_unique<GalleryTree>(scene, method, threads, progress);
}

}  // namespace stbvh::harness::gallery
