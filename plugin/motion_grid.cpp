#include "plugin/motion_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stbvh::plugin {
namespace {

/// Embree cannot divide up a time range of which next to nothing lies in [0, 1] (3.13.5 stops in an
/// assertion, or never ends): below this width, or beyond this distance, the grid spans [0, 1] instead.
constexpr double kMinAliveWidth = 1.0 / 1024;
constexpr float kMaxTime = 64.0f;

/// Bounds the rounding of times and positions here, in the kernels and in Embree, relative to their
/// magnitude: each is a handful of operations in float (2^-24 each); 2^-20 allows 16.
constexpr double kRounding = 1.0 / (1 << 20);

/// What Embree takes.
constexpr std::size_t kMostSteps = 129;

constexpr double kNothing = -std::numeric_limits<double>::infinity();

bool is_static(const MeshMotion& mesh) {
  return mesh.steps.size() == 1;
}

/// The part of [0, 1] in which a mesh is alive; empty where begin > end.
struct Interval {
  double begin, end;
  double width() const { return end - begin; }
};

Interval alive(const MeshMotion& mesh) {
  if (is_static(mesh)) return {0.0, 1.0};
  return {std::max(0.0, double{mesh.time_range.begin}), std::min(1.0, double{mesh.time_range.end})};
}

/// Calls the six faces of a box alike: 0 to 2 upper x, y, z; 3 to 5 the lower ones, negated.
double face_value(const Box3f& box, int face) {
  const Vec3f& corner = face < 3 ? box.upper : box.lower;
  const double value = face % 3 == 0 ? corner.x : face % 3 == 1 ? corner.y : corner.z;
  return face < 3 ? value : -value;
}

double time_of_step(const MeshMotion& mesh, std::size_t step) {
  if (!mesh.step_times.empty()) return mesh.step_times[step];
  const double begin = mesh.time_range.begin, end = mesh.time_range.end;
  return begin + (end - begin) * static_cast<double>(step) / static_cast<double>(mesh.steps.size() - 1);
}

/// Where a time falls among equidistant steps: between `index` and `index + 1`.
struct Position {
  std::size_t index;
  double fraction;
};

Position locate(double time, double begin, double end, std::size_t segments) {
  const double count = static_cast<double>(segments);
  const double u = std::clamp((time - begin) / (end - begin) * count, 0.0, count);
  const std::size_t index = std::min(static_cast<std::size_t>(u), segments - 1);
  return {index, u - static_cast<double>(index)};
}

Position locate(const MeshMotion& mesh, double time) {
  if (mesh.step_times.empty())
    return locate(time, mesh.time_range.begin, mesh.time_range.end, mesh.steps.size() - 1);
  const std::vector<float>& times = mesh.step_times;
  const auto next = std::upper_bound(times.begin() + 1, times.end() - 1, time);
  const double begin = *(next - 1);
  return {static_cast<std::size_t>(next - 1 - times.begin()),
          std::clamp((time - begin) / (*next - begin), 0.0, 1.0)};
}

double lerp(double a, double b, double f) {
  return (1 - f) * a + f * b;
}

double face_at(const MeshMotion& mesh, int face, double time) {
  if (is_static(mesh)) return face_value(mesh.steps[0], face);
  const Position p = locate(mesh, time);
  return lerp(face_value(mesh.steps[p.index], face), face_value(mesh.steps[p.index + 1], face), p.fraction);
}

/// One face of the grid's boxes as a function of time, kept above that face of every mesh.
class FaceEnvelope {
 public:
  FaceEnvelope(Interval range, std::size_t segments, int face)
      : range_(range), face_(face), values_(segments + 1, kNothing) {}

  void cover(std::span<const MeshMotion> meshes) {
    for (const MeshMotion& mesh : meshes) cover_grid_times(mesh);
    fill_gaps();
    for (const MeshMotion& mesh : meshes) {
      if (!is_static(mesh)) cover_steps(mesh);
      measure(mesh);
    }
  }

  /// The face at a step, padded.
  double padded(std::size_t step) const {
    double speed = speed_;
    for (std::size_t i = 1; i < values_.size(); ++i) {
      speed = std::max(speed, std::fabs(values_[i] - values_[i - 1]) / segment_width());
    }
    return values_[step] + kRounding * (magnitude_ + speed);
  }

 private:
  double segment_width() const { return range_.width() / static_cast<double>(values_.size() - 1); }
  double time(std::size_t step) const { return range_.begin + static_cast<double>(step) * segment_width(); }

  /// At each grid time next to which the mesh is alive, its face there, or where it is alive nearest to
  /// there.
  void cover_grid_times(const MeshMotion& mesh) {
    const Interval life = alive(mesh);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double t = time(i);
      if (life.end < t - segment_width() || life.begin > t + segment_width()) continue;
      values_[i] = std::max(values_[i], face_at(mesh, face_, std::clamp(t, life.begin, life.end)));
    }
  }

  /// Grid times at which nothing is alive get the nearest value: Embree drops geometries with an empty box.
  void fill_gaps() {
    for (std::size_t i = 1; i < values_.size(); ++i) {
      if (values_[i] == kNothing) values_[i] = values_[i - 1];
    }
    for (std::size_t i = values_.size() - 1; i-- > 0;) {
      if (values_[i] == kNothing) values_[i] = values_[i + 1];
    }
  }

  /// Both functions are linear between their steps: above at all grid times (done before) and at all steps of
  /// the mesh is above everywhere. Shifting both ends of a segment by d shifts all of it by d.
  void cover_steps(const MeshMotion& mesh) {
    const Interval life = alive(mesh);
    cover_sample(life.begin, face_at(mesh, face_, life.begin));
    cover_sample(life.end, face_at(mesh, face_, life.end));
    for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
      const double t = time_of_step(mesh, step);
      if (t > life.begin && t < life.end) cover_sample(t, face_value(mesh.steps[step], face_));
    }
  }

  void cover_sample(double t, double value) {
    const Position p = locate(t, range_.begin, range_.end, values_.size() - 1);
    const double missing = value - lerp(values_[p.index], values_[p.index + 1], p.fraction);
    if (missing <= 0) return;
    values_[p.index] += missing;
    values_[p.index + 1] += missing;
  }

  void measure(const MeshMotion& mesh) {
    for (std::size_t step = 0; step < mesh.steps.size(); ++step) {
      const double value = face_value(mesh.steps[step], face_);
      magnitude_ = std::max(magnitude_, std::fabs(value));
      if (step == 0) continue;
      const double seconds = time_of_step(mesh, step) - time_of_step(mesh, step - 1);
      speed_ = std::max(speed_, std::fabs(value - face_value(mesh.steps[step - 1], face_)) / seconds);
    }
  }

  Interval range_;
  int face_;
  std::vector<double> values_;
  double magnitude_ = 0;
  double speed_ = 0;
};

/// Rounded up, and within what Embree takes for valid.
float face_to_float(double value) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  const float limit = std::nextafter(kMaxCoordinate, 0.0f);
  if (value >= limit) return limit;
  const auto rounded = static_cast<float>(value);
  return rounded < value ? std::nextafter(rounded, inf) : rounded;
}

Interval common_range(std::span<const MeshMotion> meshes) {
  Interval hull{1.0, 0.0};
  for (const MeshMotion& mesh : meshes) {
    const Interval life = alive(mesh);
    hull = {std::min(hull.begin, life.begin), std::max(hull.end, life.end)};
  }
  return hull.width() < kMinAliveWidth ? Interval{0.0, 1.0} : hull;
}

std::size_t common_segments(std::span<const MeshMotion> meshes, Interval range) {
  double shortest = range.width();
  for (const MeshMotion& mesh : meshes) {
    for (std::size_t step = 1; step < mesh.steps.size(); ++step)
      shortest = std::min(shortest, time_of_step(mesh, step) - time_of_step(mesh, step - 1));
  }
  // A little less, so that 8 segments in float times do not become 9.
  const double wanted = std::ceil(range.width() / shortest - 1e-3);
  return static_cast<std::size_t>(std::clamp(wanted, 1.0, static_cast<double>(kMostSteps - 1)));
}

MotionGrid fit_common_grid(std::span<const MeshMotion> meshes) {
  const Interval range = common_range(meshes);
  const std::size_t segments = common_segments(meshes, range);
  MotionGrid grid{{static_cast<float>(range.begin), static_cast<float>(range.end)}, {}};
  std::vector<FaceEnvelope> faces;
  for (int face = 0; face < 6; ++face) {
    faces.emplace_back(range, segments, face).cover(meshes);
  }
  for (std::size_t step = 0; step <= segments; ++step) {
    std::array<float, 6> f;
    for (std::size_t face = 0; face < 6; ++face) f[face] = face_to_float(faces[face].padded(step));
    grid.steps.push_back({{-f[3], -f[4], -f[5]}, {f[0], f[1], f[2]}});
  }
  return grid;
}

MotionGrid static_grid(std::span<const MeshMotion> meshes) {
  MotionGrid grid{{0.0f, 1.0f}, {Box3f::empty()}};
  for (const MeshMotion& mesh : meshes) grid.steps[0].extend(mesh.steps[0]);
  return grid;
}

/// Whether Embree can take the mesh's own steps as they are.
bool is_plain(const MeshMotion& mesh) {
  return mesh.step_times.empty() && mesh.steps.size() <= kMostSteps &&
         alive(mesh).width() >= kMinAliveWidth && mesh.time_range.begin >= -kMaxTime &&
         mesh.time_range.end <= kMaxTime;
}

}  // namespace

MotionGrid fit_motion_grid(std::span<const MeshMotion> meshes) {
  std::vector<MeshMotion> visible;
  for (const MeshMotion& mesh : meshes) {
    if (mesh.steps[0].lower.x <= mesh.steps[0].upper.x && alive(mesh).width() >= 0) visible.push_back(mesh);
  }
  if (std::all_of(visible.begin(), visible.end(), is_static)) return static_grid(visible);
  if (visible.size() == 1 && is_plain(visible[0])) return {visible[0].time_range, visible[0].steps};
  return fit_common_grid(visible);
}

}  // namespace stbvh::plugin
