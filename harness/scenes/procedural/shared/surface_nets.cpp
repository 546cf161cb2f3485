/// Surface nets (Gibson 1998) on a lattice of blocks, of which only those near the surface are looked at.
#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <numeric>
#include <unordered_map>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/procedural/shared/implicit_body.h"

namespace stbvh::harness {
namespace {

constexpr int kBlock = 8;            ///< cells along a block's edge
constexpr int kPoints = kBlock + 1;  ///< lattice points along it
constexpr std::uint32_t kNoVertex = 0xFFFFFFFFu;

struct Cell {
  int x, y, z;
};

/// Position of a cell or block in its array.
std::size_t flat(int x, int y, int z, int n) {
  return static_cast<std::size_t>((z * n + y) * n + x);
}

std::uint64_t block_key(int x, int y, int z) {
  return (static_cast<std::uint64_t>(x) << 42) | (static_cast<std::uint64_t>(y) << 21) |
         static_cast<std::uint64_t>(z);
}

/// Cells of one block that the surface crosses.
struct Block {
  Cell origin;                           ///< in cells
  std::vector<double> distance;          ///< at its lattice points
  std::vector<std::uint32_t> vertex_of;  ///< by cell, kNoVertex if not crossed
  std::uint32_t vertex_count = 0;
  std::uint32_t first_vertex = 0;      ///< of the whole shape
  std::vector<std::uint32_t> indices;  ///< of its triangles

  double at(int x, int y, int z) const { return distance[flat(x, y, z, kPoints)]; }
};

class SurfaceNet {
 public:
  SurfaceNet(const ImplicitBody& body, double cell) : body_(body), cell_(cell) {
    Vec3 upper;
    body.bounds(lower_, upper);
    lower_ = lower_ - Vec3{cell, cell, cell} * 2.0;
    const Vec3 extent = upper - lower_ + Vec3{cell, cell, cell} * 2.0;
    const auto blocks = [&](double e) { return static_cast<int>(std::ceil(e / (cell * kBlock))); };
    counts_ = {blocks(extent.x), blocks(extent.y), blocks(extent.z)};
  }

  /// The triangles that shape() will have: much cheaper, as no vertex has to be placed.
  std::size_t count_triangles() {
    find_blocks();
    for_all(blocks_.size(), [this](std::size_t b) { fill(blocks_[b]); });
    std::vector<std::size_t> counts(blocks_.size());
    for_all(blocks_.size(),
            [&](std::size_t b) { for_each_face(blocks_[b], [&](const Quad&) { counts[b] += 2; }); });
    return std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  }

  /// After count_triangles().
  Shape shape() {
    std::uint32_t vertices = 0;
    for (Block& block : blocks_) {
      block.first_vertex = vertices;
      vertices += block.vertex_count;
    }
    Shape shape;
    shape.positions.resize(vertices);
    for_all(blocks_.size(), [&](std::size_t b) { place_vertices(blocks_[b], shape.positions); });
    for_all(blocks_.size(), [&](std::size_t b) {
      std::vector<std::uint32_t>& indices = blocks_[b].indices;
      for_each_face(blocks_[b], [&](const Quad& quad) { add_triangles(quad, shape.positions, indices); });
    });
    for (const Block& block : blocks_)
      shape.indices.insert(shape.indices.end(), block.indices.begin(), block.indices.end());
    return shape;
  }

 private:
  using Quad = std::array<std::uint32_t, 4>;

  Vec3 point(Cell c) const {
    return lower_ +
           Vec3{static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z)} * cell_;
  }

  void find_blocks() {
    const double half = 0.5 * kBlock * cell_;
    const double reach = std::sqrt(3.0) * half;
    for (int z = 0; z < counts_.z; ++z) {
      check_cancelled();
      for (int y = 0; y < counts_.y; ++y) {
        for (int x = 0; x < counts_.x; ++x) {
          const Cell origin{x * kBlock, y * kBlock, z * kBlock};
          // Tapered blobs change a little faster than the distance itself.
          if (std::abs(body_.distance(point(origin) + Vec3{half, half, half})) > 1.4 * reach) continue;
          block_at_[block_key(x, y, z)] = blocks_.size();
          blocks_.emplace_back().origin = origin;
        }
      }
    }
  }

  /// What of the body matters in the block.
  ImplicitBody body_near(const Block& block) const {
    const double half = 0.5 * kBlock * cell_;
    const Vec3 center = point(block.origin) + Vec3{half, half, half};
    return body_.near(center, 1.4 * std::sqrt(3.0) * half);
  }

  template <class Visit>
  static void for_each_cell(const Visit& visit) {
    for (int z = 0; z < kBlock; ++z) {
      for (int y = 0; y < kBlock; ++y) {
        for (int x = 0; x < kBlock; ++x) visit(Cell{x, y, z});
      }
    }
  }

  /// Measures the distances, and numbers the cells that the surface crosses.
  void fill(Block& block) const {
    const ImplicitBody local = body_near(block);
    block.distance.reserve(flat(0, 0, kPoints, kPoints));
    for (int z = 0; z < kPoints; ++z) {
      for (int y = 0; y < kPoints; ++y) {
        for (int x = 0; x < kPoints; ++x)
          block.distance.push_back(
              local.distance(point({block.origin.x + x, block.origin.y + y, block.origin.z + z})));
      }
    }
    block.vertex_of.assign(flat(0, 0, kBlock, kBlock), kNoVertex);
    for_each_cell([&](Cell c) {
      if (is_crossed(block, c)) block.vertex_of[flat(c.x, c.y, c.z, kBlock)] = block.vertex_count++;
    });
  }

  /// Whether some corners lie inside and some outside.
  static bool is_crossed(const Block& block, Cell c) {
    int inside = 0;
    for (int corner = 0; corner < 8; ++corner)
      inside += block.at(c.x + (corner & 1), c.y + (corner >> 1 & 1), c.z + (corner >> 2)) < 0 ? 1 : 0;
    return inside != 0 && inside != 8;
  }

  void place_vertices(const Block& block, std::vector<Vec3>& positions) const {
    if (block.vertex_count == 0) return;
    const ImplicitBody local = body_near(block);
    for_each_cell([&](Cell c) {
      const std::uint32_t vertex = block.vertex_of[flat(c.x, c.y, c.z, kBlock)];
      if (vertex != kNoVertex) positions[block.first_vertex + vertex] = vertex_of_cell(block, local, c);
    });
  }

  /// The mean of the points where the cell's edges cross the surface, moved onto it.
  Vec3 vertex_of_cell(const Block& block, const ImplicitBody& local, Cell c) const {
    Vec3 sum;
    int crossings = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Cell a{c.x + (corner & 1), c.y + (corner >> 1 & 1), c.z + (corner >> 2)};
      for (int axis = 0; axis < 3; ++axis) {
        if (corner >> axis & 1) continue;
        const Cell b{a.x + (axis == 0), a.y + (axis == 1), a.z + (axis == 2)};
        const double da = block.at(a.x, a.y, a.z);
        const double db = block.at(b.x, b.y, b.z);
        if ((da < 0) == (db < 0)) continue;
        sum = sum + lerp(point(a), point(b), da / (da - db));
        ++crossings;
      }
    }
    Vec3 p = sum * (1.0 / crossings) + (point(block.origin) - lower_);
    for (int iteration = 0; iteration < 2; ++iteration) {
      const Vec3 g = local.gradient(p, 0.1 * cell_);
      const double squared = std::max(dot(g, g), 0.05);
      const double move = std::clamp(local.distance(p) / squared, -0.5 * cell_, 0.5 * cell_);
      p = p - g * move;
    }
    return p;
  }

  std::uint32_t vertex(Cell c) const {
    if (c.x < 0 || c.y < 0 || c.z < 0) return kNoVertex;
    const auto found = block_at_.find(block_key(c.x / kBlock, c.y / kBlock, c.z / kBlock));
    if (found == block_at_.end()) return kNoVertex;
    const Block& block = blocks_[found->second];
    const std::uint32_t vertex = block.vertex_of[flat(c.x % kBlock, c.y % kBlock, c.z % kBlock, kBlock)];
    return vertex == kNoVertex ? kNoVertex : block.first_vertex + vertex;
  }

  /// Visits the four vertices about each lattice edge of the block that crosses the surface.
  template <class Visit>
  void for_each_face(const Block& block, const Visit& visit) const {
    for_each_cell([&](Cell cell) {
      const auto [x, y, z] = cell;
      const bool inside = block.at(x, y, z) < 0;
      const Cell c{block.origin.x + x, block.origin.y + y, block.origin.z + z};
      if (inside != (block.at(x + 1, y, z) < 0)) visit_face(c, {0, 1, 0}, {0, 0, 1}, inside, visit);
      if (inside != (block.at(x, y + 1, z) < 0)) visit_face(c, {0, 0, 1}, {1, 0, 0}, inside, visit);
      if (inside != (block.at(x, y, z + 1) < 0)) visit_face(c, {1, 0, 0}, {0, 1, 0}, inside, visit);
    });
  }

  template <class Visit>
  void visit_face(Cell c, Cell u, Cell v, bool outward, const Visit& visit) const {
    Quad q{vertex({c.x - u.x - v.x, c.y - u.y - v.y, c.z - u.z - v.z}),
           vertex({c.x - v.x, c.y - v.y, c.z - v.z}), vertex(c), vertex({c.x - u.x, c.y - u.y, c.z - u.z})};
    if (std::find(q.begin(), q.end(), kNoVertex) != q.end()) return;
    if (!outward) std::swap(q[1], q[3]);
    visit(q);
  }

  /// Cut along the shorter diagonal.
  static void add_triangles(const Quad& q, const std::vector<Vec3>& positions,
                            std::vector<std::uint32_t>& indices) {
    const auto diagonal = [&](std::size_t i, std::size_t j) {
      return length(positions[q[i]] - positions[q[j]]);
    };
    const std::size_t turn = diagonal(0, 2) <= diagonal(1, 3) ? 0 : 1;
    for (const std::size_t i : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(q[(i + turn) % 4]);
  }

  const ImplicitBody& body_;
  double cell_;
  Vec3 lower_;
  Cell counts_{};
  std::vector<Block> blocks_;
  std::unordered_map<std::uint64_t, std::size_t> block_at_;
};

}  // namespace

Shape polygonise(const ImplicitBody& body, double cell) {
  SurfaceNet net(body, cell);
  net.count_triangles();
  return net.shape();
}

Shape polygonise_to_count(const ImplicitBody& body, std::size_t triangles) {
  Vec3 lower, upper;
  body.bounds(lower, upper);
  double cell = length(upper - lower) / 60;
  std::unique_ptr<SurfaceNet> best;
  double best_miss = std::numeric_limits<double>::infinity();
  // The count goes with 1 / cell^2; a coarse first try measures the surface.
  for (int attempt = 0; attempt < 6 && best_miss > 0.01; ++attempt) {
    auto net = std::make_unique<SurfaceNet>(body, cell);
    const double ratio = static_cast<double>(net->count_triangles()) / static_cast<double>(triangles);
    const double miss = ratio > 0 ? std::abs(std::log(ratio)) : best_miss;
    if (miss < best_miss) {
      best_miss = miss;
      best = std::move(net);
    }
    // Cells larger than the body find nothing of it.
    cell *= ratio > 0 ? std::sqrt(ratio) : 0.6;
  }
  return best ? best->shape() : Shape();
}

}  // namespace stbvh::harness
