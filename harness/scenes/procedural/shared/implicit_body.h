/// Bodies modelled as blended, tapered capsules, each of which belongs to a joint, and their surfaces as
/// meshes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "harness/scenes/procedural/shared/mesh_tools.h"

namespace stbvh::harness {

/// Tapered capsule from `a` (radius_a) to `b` (radius_b), flattened by `scale` (factors <= 1 along the axes,
/// about `a`), melting into the others within the distance `blend`.
struct Blob {
  Vec3 a, b;
  double radius_a, radius_b;
  std::size_t joint;
  double blend = 0.03;
  Vec3 scale{1, 1, 1};
  bool carve = false;  ///< taken away instead of added

  /// Distance to the surface or less, negative inside.
  double distance(Vec3 p) const;
};

/// Up to four joints that a vertex follows; weights sum to 1.
struct SkinWeights {
  std::array<std::uint32_t, 4> joints{};
  std::array<double, 4> weights{};
};

class ImplicitBody {
 public:
  void add(const Blob& blob) { blobs_.push_back(blob); }
  const std::vector<Blob>& blobs() const { return blobs_; }

  /// Blended distance: 0 on the surface, negative inside.
  double distance(Vec3 p) const;
  /// The blobs without which nothing changes on a surface within `radius` of `center`.
  ImplicitBody near(Vec3 center, double radius) const;
  Vec3 gradient(Vec3 p, double h) const;
  /// Weights of the joints near `p`: the joint of the nearest blob and those that `parents` joins to it.
  SkinWeights weights(Vec3 p, const std::vector<std::size_t>& parents) const;
  void bounds(Vec3& lower, Vec3& upper) const;

 private:
  std::vector<Blob> blobs_;
};

/// Closed surface of `body` by surface nets on cells of size `cell`, its vertices moved onto the surface.
Shape polygonise(const ImplicitBody& body, double cell);

/// As above with a cell size that gives `triangles` within a few percent (further off below some
/// hundreds).
Shape polygonise_to_count(const ImplicitBody& body, std::size_t triangles);

}  // namespace stbvh::harness
