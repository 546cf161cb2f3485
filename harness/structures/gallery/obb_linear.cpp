/// `obb-linear`: oriented boxes at both ends of the shutter, interpolated (Hou et al. 2010, micropolygon ray
/// tracing with defocus and motion blur).
///
/// Stored: nodes of eight children (obb_linear_nodes.inl), each in a box of a frame of its own, which moves
/// linearly over the whole shutter. Built: as `linear`; then a frame is fitted to the vertices below each
/// child, the world's axes or the principal axes of where the vertices are, whichever box has the least
/// surface at the centre of the shutter. Faces are the lines that are tightest there over all steps.
/// Traversed: the ray is turned into the frames of eight children at once.
///
/// The full paper was not to be had; inferred: both boxes of a child share their axes (interpolated between
/// unlike axes they would not bound what moves), how axes are chosen, and the topology. The paper's boxes are
/// made of grids of micropolygons; here they hold triangles of any number of steps.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "harness/structures/gallery/gallery.h"
#include "harness/structures/gallery/obb_linear_nodes.inl"
#include "harness/structures/gallery/object_splits.h"
#include "harness/structures/gallery/projection.h"
#include "harness/structures/gallery/wide_nodes.h"

namespace stbvh::harness::gallery {
namespace {

using Frame = std::array<std::array<float, 3>, 3>;  ///< rows
constexpr Frame kWorld{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// The mean of products of two coordinates, of points around their mean.
class Covariance {
 public:
  void add(const Point& p) {
    ++count_;
    for (std::size_t i = 0; i < 3; ++i) {
      sum_[i] += p[i];
      for (std::size_t j = 0; j < 3; ++j) products_[i][j] += p[i] * p[j];
    }
  }

  /// Its eigenvectors as rows: Jacobi's rotations, each of which makes one element off the diagonal vanish.
  Frame principal_axes() const {
    double a[3][3];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j)
        a[i][j] = products_[i][j] / count_ - sum_[i] / count_ * (sum_[j] / count_);
    }
    double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < 12; ++sweep) {
      for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) rotate(a, axes, p, q);
    }
    Frame frame;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) frame[i][j] = static_cast<float>(axes[i][j]);
    }
    return frame;
  }

 private:
  static void rotate(double (&a)[3][3], double (&axes)[3][3], int p, int q) {
    if (!(std::fabs(a[p][q]) > 0)) return;
    const double angle = 0.5 * std::atan2(2 * a[p][q], a[q][q] - a[p][p]);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    for (auto& row : a) {
      const double at_p = row[p];
      row[p] = c * at_p - s * row[q];
      row[q] = s * at_p + c * row[q];
    }
    for (auto* const matrix : {a, axes}) {
      for (int j = 0; j < 3; ++j) {
        const double at_p = matrix[p][j];
        matrix[p][j] = c * at_p - s * matrix[q][j];
        matrix[q][j] = s * at_p + c * matrix[q][j];
      }
    }
  }

  double count_ = 0;
  double sum_[3] = {};
  double products_[3][3] = {};
};

class ObbMethod {
 public:
  /// A leaf, or the bounds of a node's children, which stay where they are in memory.
  struct Bounds {
    const BinaryLeaf* leaf = nullptr;
    std::vector<const Bounds*> children;
  };

  ObbMethod(const BuildContext& context, const BinaryNode& root, const Point& centre)
      : context_(context), range_(root.range), centre_(centre) {
    for (const BuildMesh& mesh : context.meshes) samples_.emplace_back(mesh, range_);
  }

  Bounds of_leaf(const BinaryLeaf& leaf) const { return {&leaf, {}}; }
  Bounds joined(std::span<const Bounds* const> children) const {
    return {nullptr, {children.begin(), children.end()}};
  }
  std::size_t bytes(std::span<const Bounds* const>) const { return sizeof(ObbNode); }

  void write(std::span<const Bounds* const> children, std::span<const Link> links, std::byte* out) const {
    constexpr float inf = std::numeric_limits<float>::infinity();
    auto& node = *new (out) ObbNode{};
    for (int plane = 0; plane < kPlanes; ++plane)
      std::fill_n(node.planes[plane], kWidth, plane < kUpperX ? inf : -inf);
    std::copy(links.begin(), links.end(), node.children);
    tbb::parallel_for(std::size_t{0}, children.size(), [&](std::size_t child) {
      const auto& [frame, bounds] = fitted(*children[child]);
      for (int i = 0; i < 3; ++i) {
        const auto& row = frame[static_cast<std::size_t>(i)];
        for (int j = 0; j < 3; ++j) node.frames[i][j][child] = row[static_cast<std::size_t>(j)];
        const auto set = [&](int plane, bool upper) {
          const F32x4& begin = upper ? bounds.begin.upper : bounds.begin.lower;
          const F32x4& end = upper ? bounds.end.upper : bounds.end.lower;
          const Face face = make_face(begin[i], end[i], range_.length(), upper);
          node.planes[plane + i][child] = face.plane;
          node.slopes[plane + i][child] = face.slope;
        };
        set(kLowerX, false);
        set(kUpperX, true);
      }
    });
  }

 private:
  using Leaves = std::vector<const BinaryLeaf*>;
  static constexpr std::size_t kSampledLeaves = 128;  ///< that frames are chosen by

  struct OrientedBounds {
    Frame frame;
    LinearBounds bounds;
  };

  static void collect(const Bounds& bounds, Leaves& leaves) {
    if (bounds.leaf != nullptr) leaves.push_back(bounds.leaf);
    for (const Bounds* child : bounds.children) collect(*child, leaves);
  }

  OrientedBounds fitted(const Bounds& child) const {
    Leaves all;
    collect(child, all);
    std::ranges::stable_sort(all, {}, &BinaryLeaf::mesh);
    Leaves sampled;
    const std::size_t stride = (all.size() + kSampledLeaves - 1) / kSampledLeaves;
    for (std::size_t i = 0; i < all.size(); i += stride) sampled.push_back(all[i]);
    OrientedBounds best = in_frame(kWorld, sampled);
    for (const Frame& frame : {axes_at_centre(sampled), axes_at_all_times(sampled)})
      best = smaller(best, in_frame(frame, sampled));
    if (stride == 1) return best;
    return smaller(in_frame(kWorld, all), in_frame(best.frame, all));
  }

  static const OrientedBounds& smaller(const OrientedBounds& a, const OrientedBounds& b) {
    return b.bounds.centre_area() < a.bounds.centre_area() ? b : a;
  }

  /// The places of a leaf's vertices at one sample.
  template <typename Body>
  void for_each_vertex(const BinaryLeaf& leaf, const MotionSamples::Sample& at, const Body& body) const {
    const BuildMesh& mesh = context_.meshes[leaf.mesh];
    for (const std::uint32_t vertex : leaf.meshlet->used_vertices()) {
      const Point p = relative(mesh.position(at.segment, vertex), centre_);
      if (at.fraction == 0.0f) {
        body(p);
      } else {
        body(mixed(p, relative(mesh.position(at.segment + 1, vertex), centre_), at.fraction));
      }
    }
  }

  Frame axes_at_centre(const Leaves& leaves) const {
    Covariance places;
    for (const BinaryLeaf* leaf : leaves) {
      const BuildMesh& mesh = context_.meshes[leaf->mesh];
      MotionSamples::Sample at{};
      if (!mesh.is_static()) {
        const ClosedTimeRange alive = mesh.alive(range_);
        const SegmentTime centre = mesh.segment_at(0.5f * alive.begin + 0.5f * alive.last);
        at = {0.5f, centre.fraction, centre.segment};
      }
      for_each_vertex(*leaf, at, [&](const Point& p) { places.add(p); });
    }
    return places.principal_axes();
  }

  Frame axes_at_all_times(const Leaves& leaves) const {
    Covariance places;
    for (const BinaryLeaf* leaf : leaves) {
      for (const MotionSamples::Sample& at : samples_[leaf->mesh].samples)
        for_each_vertex(*leaf, at, [&](const Point& p) { places.add(p); });
    }
    return places.principal_axes();
  }

  /// `leaves` are sorted by their mesh.
  OrientedBounds in_frame(const Frame& frame, const Leaves& leaves) const {
    OrientedBounds result{frame, LinearBounds::empty()};
    for (auto first = leaves.begin(); first != leaves.end();) {
      const auto is_of_mesh = [&](const BinaryLeaf* leaf) { return leaf->mesh == (*first)->mesh; };
      const auto last = std::find_if_not(first, leaves.end(), is_of_mesh);
      result.bounds.extend(of_one_mesh(frame, std::span(first, last)));
      first = last;
    }
    return result;
  }

  LinearBounds of_one_mesh(const Frame& frame, std::span<const BinaryLeaf* const> leaves) const {
    const std::uint32_t mesh = leaves.front()->mesh;
    ProjectedMotion<3> motion(context_.meshes[mesh], samples_[mesh], centre_, frame);
    for (const BinaryLeaf* leaf : leaves) motion.extend(*leaf->meshlet);
    const auto intervals = motion.padded();
    std::vector<BoundsSample> boxes;
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      const auto& [x, y, z] = intervals[i];
      boxes.push_back({samples_[mesh].samples[i].parameter,
                       {F32x4(rounded_down(x.lower), rounded_down(y.lower), rounded_down(z.lower)),
                        F32x4(rounded_up(x.upper), rounded_up(y.upper), rounded_up(z.upper))}});
    }
    if (boxes.size() > 1 && samples_[mesh].covers_range) return tightest_at_centre(boxes);
    Box4 at_all_times = Box4::empty();
    for (const BoundsSample& sample : boxes) at_all_times.extend(sample.box);
    return {at_all_times, at_all_times};
  }

  const BuildContext& context_;
  ClosedTimeRange range_;
  Point centre_;
  std::vector<MotionSamples> samples_;  ///< of each mesh
};

std::vector<OutlinedChild> obb_children_at(const GalleryView& view, Link link, float time) {
  const auto& node = *reinterpret_cast<const ObbNode*>(view.data + unit_of(link) * kUnitBytes);
  const auto& centre = static_cast<const ObbScene*>(view.method)->centre;
  std::vector<OutlinedChild> children;
  for (std::size_t child = 0; child < kWidth; ++child) {
    if (node.planes[kLowerX][child] > node.planes[kUpperX][child]) continue;  // empty
    const auto face = [&](Plane plane) {
      return node.planes[plane][child] + (time - view.time_begin) * node.slopes[plane][child];
    };
    Outline corners = corners_of(
        {{face(kLowerX), face(kLowerY), face(kLowerZ)}, {face(kUpperX), face(kUpperY), face(kUpperZ)}});
    for (Vec3f& corner : corners) {  // back by the transpose, which is the inverse but for rounding
      const float turned[] = {corner.x, corner.y, corner.z};
      float p[3] = {centre[0], centre[1], centre[2]};
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) p[j] += node.frames[i][j][child] * turned[i];
      }
      corner = {p[0], p[1], p[2]};
    }
    children.push_back({node.children[child], std::move(corners)});
  }
  return children;
}

WrittenTree write_obb(BuildContext& context, BinaryNode& root) {
  const Vec3f c = centre_of(root);
  const auto shared = std::make_shared<ObbScene>(ObbScene{{c.x, c.y, c.z}});
  const ObbMethod method(context, root, {c.x, c.y, c.z});
  return write_wide_nodes(context, method, root, method_kernels().obb_linear, obb_children_at, shared,
                          sizeof *shared);
}

}  // namespace

StructurePtr build_obb_linear(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  GalleryTree::Method method;
  method.make_builder = [](BuildContext& context) { return std::make_unique<ObjectSplits>(context); };
  method.write = write_obb;
  return std::make_unique<GalleryTree>(scene, method, threads, progress);
}

}  // namespace stbvh::harness::gallery
