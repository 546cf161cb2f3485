#include "harness/scenes/procedural/llama/fur.h"

#include <algorithm>
#include <array>

#include "harness/scenes/cancellation.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kAround = 3;

/// Root of a strand on triangle `triangle` and its shape in rest space.
struct Strand {
  std::array<std::uint32_t, 3> corners;
  std::array<double, 3> barycentric;
  std::uint32_t number;  ///< of its random numbers
  FurAt fur;
};

Vec3 corner_mix(const std::vector<Vec3>& positions, const Strand& strand) {
  Vec3 p;
  for (std::size_t k = 0; k < 3; ++k) p = p + positions[strand.corners[k]] * strand.barycentric[k];
  return p;
}

Vec3 triangle_normal(Vec3 a, Vec3 b, Vec3 c) {
  return normalize(cross(b - a, c - a));
}

/// Running sums of the triangles' share of the fur: their area times density.
std::vector<double> cumulative_density(const Shape& shape, const std::function<FurAt(Vec3, Vec3)>& fur_at) {
  std::vector<double> share(shape.triangle_count());
  for_all(share.size(), [&](std::size_t t) {
    const Vec3 a = shape.positions[shape.indices[3 * t]];
    const Vec3 b = shape.positions[shape.indices[3 * t + 1]];
    const Vec3 c = shape.positions[shape.indices[3 * t + 2]];
    const FurAt fur = fur_at((a + b + c) * (1.0 / 3), triangle_normal(a, b, c));
    share[t] = fur.length > 0 ? 0.5 * length(cross(b - a, c - a)) * fur.density : 0.0;
  });
  for (std::size_t t = 1; t < share.size(); ++t) share[t] += share[t - 1];
  return share;
}

/// Roots spread evenly over the surface: in the order of its triangles, so that neighbours lie together in
/// memory.
std::vector<Strand> plant(const Shape& shape, const FurSettings& settings,
                          const std::function<FurAt(Vec3, Vec3)>& fur_at) {
  const std::vector<double> cumulative = cumulative_density(shape, fur_at);
  std::vector<Strand> strands(settings.strands);
  if (cumulative.empty() || cumulative.back() <= 0) return {};
  for_all(strands.size(), [&](std::size_t i) {
    Pcg32 random(settings.seed, 2 * i);
    const double place = (static_cast<double>(i) + random.uniform()) / static_cast<double>(strands.size());
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), place * cumulative.back());
    const auto t = std::min(static_cast<std::size_t>(found - cumulative.begin()), cumulative.size() - 1);
    const double root = std::sqrt(random.uniform());
    const double other = random.uniform();
    Strand& strand = strands[i];
    strand.number = static_cast<std::uint32_t>(i);
    strand.barycentric = {1 - root, root * (1 - other), root * other};
    for (std::size_t k = 0; k < 3; ++k) strand.corners[k] = shape.indices[3 * t + k];
    const Vec3 a = shape.positions[strand.corners[0]], b = shape.positions[strand.corners[1]];
    const Vec3 normal = triangle_normal(a, b, shape.positions[strand.corners[2]]);
    strand.fur = fur_at(corner_mix(shape.positions, strand), normal);
    // At the border of bald skin the triangle grows hair but the point may not: shorter hair then.
    strand.fur.length = std::max(strand.fur.length, 4 * settings.root_radius);
  });
  return strands;
}

/// Writes the vertices of one strand: rings of three and the tip.
class StrandWriter {
 public:
  StrandWriter(const SkinnedShape& skin, const FurSettings& settings) : skin_(skin), settings_(settings) {}

  void write(const Strand& strand, const std::vector<Vec3>& posed, Vec3 lag, double time, Vec3f* out) const {
    const std::vector<Vec3>& rest = skin_.shape.positions;
    const Vec3 rest_normal =
        triangle_normal(rest[strand.corners[0]], rest[strand.corners[1]], rest[strand.corners[2]]);
    const Vec3 normal =
        triangle_normal(posed[strand.corners[0]], posed[strand.corners[1]], posed[strand.corners[2]]);
    const Quaternion turn = frame_turn(strand, rest, rest_normal, posed, normal);
    Pcg32 random(settings_.seed, 2 * std::uint64_t{strand.number} + 1);
    const Vec3 jitter{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const double reach = strand.fur.length * random.uniform(0.7, 1.15);
    const double phase = random.uniform(0, 2 * kPi);
    const Vec3 flat = normalize(strand.fur.combed - rest_normal * dot(strand.fur.combed, rest_normal));
    const double lift = strand.fur.lift;
    const Vec3 first =
        rotate(turn, normalize(rest_normal * (0.35 + lift) + flat * (1 - lift) + jitter * 0.25));
    const Vec3 last = rotate(turn, normalize(flat + rest_normal * (0.5 * lift) + jitter * 0.3));
    const Vec3 sway =
        cross(normal, first) *
        (settings_.sway * std::sin(2 * kPi * time + phase + 9 * dot(jitter, Vec3{0.1, 0.1, 0.1})));
    const Vec3 root = corner_mix(posed, strand) - normal * (0.5 * settings_.root_radius);
    const auto at = [&](double s) {
      return root + (first * (s * (1 - 0.5 * s)) + last * (0.5 * s * s) + sway * (s * s)) * reach +
             lag * (s * s);
    };
    const Vec3 side = normalize(cross(first, normal + jitter * 0.2));
    for (std::size_t k = 0; k < settings_.segments; ++k) {
      const double s = static_cast<double>(k) / static_cast<double>(settings_.segments);
      const Vec3 along = normalize(at(s + 0.05) - at(s));
      const Vec3 u = normalize(side - along * dot(side, along));
      const Vec3 v = cross(along, u);
      const double r = settings_.root_radius * (1 - 0.75 * s);
      for (std::size_t i = 0; i < kAround; ++i) {
        const double angle = 2 * kPi * static_cast<double>(i) / kAround;
        *out++ = to_float(at(s) + u * (r * std::cos(angle)) + v * (r * std::sin(angle)));
      }
    }
    *out = to_float(at(1));
  }

 private:
  /// The turn of the root's triangle from rest to its posed place.
  static Quaternion frame_turn(const Strand& strand, const std::vector<Vec3>& rest, Vec3 rest_normal,
                               const std::vector<Vec3>& posed, Vec3 normal) {
    const Vec3 axis = cross(rest_normal, normal);
    const double sine = length(axis);
    const Quaternion tilt =
        sine > 1e-9 ? axis_angle(axis, std::atan2(sine, dot(rest_normal, normal))) : Quaternion{};
    const Vec3 from = rotate(tilt, normalize(rest[strand.corners[1]] - rest[strand.corners[0]]));
    const Vec3 to = normalize(posed[strand.corners[1]] - posed[strand.corners[0]]);
    return axis_angle(normal, std::atan2(dot(normal, cross(from, to)), dot(from, to))) * tilt;
  }

  const SkinnedShape& skin_;
  const FurSettings& settings_;
};

std::vector<std::uint32_t> strand_indices(std::size_t strands, std::size_t segments) {
  const std::size_t each = kAround * segments + 1;
  std::vector<std::uint32_t> indices;
  indices.reserve(strands * 3 * (6 * segments - 3));
  const auto push = [&](std::size_t a, std::size_t b, std::size_t c) {
    for (const std::size_t v : {a, b, c}) indices.push_back(static_cast<std::uint32_t>(v));
  };
  for (std::size_t s = 0; s < strands; ++s) {
    const std::size_t first = s * each;
    for (std::size_t k = 0; k < segments; ++k) {
      for (std::size_t i = 0; i < kAround; ++i) {
        const std::size_t a = first + k * kAround + i, b = first + k * kAround + (i + 1) % kAround;
        if (k + 1 == segments) {
          push(a, b, first + each - 1);
        } else {
          push(a, b, b + kAround);
          push(a, b + kAround, a + kAround);
        }
      }
    }
  }
  return indices;
}

/// Positions of the skin's vertices at each step.
std::vector<std::vector<Vec3>> skinned_positions(const SkinnedShape& skin,
                                                 const std::vector<std::vector<Rigid>>& transforms) {
  std::vector<std::vector<Vec3>> posed;
  for (const std::vector<Rigid>& at_step : transforms) {
    std::vector<Vec3>& positions = posed.emplace_back(skin.shape.positions.size());
    for_all(positions.size(), [&](std::size_t i) {
      positions[i] = skin_point(skin.shape.positions[i], skin.weights[i], at_step);
    });
  }
  return posed;
}

/// The share of a shutter by which tips stay behind the skin.
constexpr double kTipLag = 0.08;

}  // namespace

std::vector<Mesh> grow_fur(const std::string& name, const SkinnedShape& skin, const FurSettings& settings,
                           const std::function<FurAt(Vec3 position, Vec3 normal)>& fur_at,
                           const std::vector<std::vector<Rigid>>& transforms) {
  const std::vector<Strand> strands = plant(skin.shape, settings, fur_at);
  std::vector<std::vector<const Strand*>> by_colour(settings.colours.size());
  for (const Strand& strand : strands) by_colour[strand.fur.colour].push_back(&strand);
  std::vector<Mesh> meshes;
  for (std::size_t c = 0; c < by_colour.size(); ++c) {
    Mesh& mesh = meshes.emplace_back();
    mesh.name = name;
    mesh.material.color = settings.colours[c];
    mesh.indices = strand_indices(by_colour[c].size(), settings.segments);
  }
  const std::size_t each = kAround * settings.segments + 1;
  const StrandWriter writer(skin, settings);
  const auto posed = skinned_positions(skin, transforms);
  for (std::size_t k = 0; k < transforms.size(); ++k) {
    // What the skin did since the step before; at the first step, what it is about to do.
    const std::vector<Vec3>& before = posed[k > 0 ? k - 1 : 0];
    const std::vector<Vec3>& after = posed[k > 0 ? k : std::min<std::size_t>(1, transforms.size() - 1)];
    for (std::size_t c = 0; c < by_colour.size(); ++c) {
      VertexBuffer& buffer = meshes[c].steps.emplace_back(by_colour[c].size() * each);
      for_all(by_colour[c].size(), [&](std::size_t i) {
        const Strand& strand = *by_colour[c][i];
        const Vec3 moved = corner_mix(before, strand) - corner_mix(after, strand);
        const double way = kTipLag * static_cast<double>(transforms.size() - 1) * length(moved);
        const Vec3 lag = normalize(moved) * std::min(way, 0.3 * strand.fur.length);
        writer.write(strand, posed[k], lag, step_time(k, transforms.size()), buffer.data() + i * each);
      });
    }
  }
  std::erase_if(meshes, [](const Mesh& mesh) { return mesh.indices.empty(); });
  return meshes;
}

}  // namespace stbvh::harness
