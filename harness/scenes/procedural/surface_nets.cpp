/// Surface nets (Gibson 1998) on a lattice of blocks, of which only those near the surface are looked at.
#include <algorithm>
#include <limits>
#include <unordered_map>

#include "harness/scenes/procedural/implicit_body.h"

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
  std::vector<Vec3> vertices;            ///< one for each crossed cell
  std::vector<std::uint32_t> vertex_of;  ///< by cell, kNoVertex if not crossed

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

  Shape run() {
    find_blocks();
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [this](std::size_t b) { fill(blocks_[b]); });
    Shape shape;
    for (Block& block : blocks_) {
      const auto first = static_cast<std::uint32_t>(shape.positions.size());
      for (std::uint32_t& v : block.vertex_of) v += v == kNoVertex ? 0 : first;
      shape.positions.insert(shape.positions.end(), block.vertices.begin(), block.vertices.end());
    }
    for (const Block& block : blocks_) add_faces(block, shape);
    return shape;
  }

 private:
  Vec3 point(Cell c) const {
    return lower_ +
           Vec3{static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z)} * cell_;
  }

  void find_blocks() {
    const double half = 0.5 * kBlock * cell_;
    const double reach = std::sqrt(3.0) * half;
    for (int z = 0; z < counts_.z; ++z) {
      for (int y = 0; y < counts_.y; ++y) {
        for (int x = 0; x < counts_.x; ++x) {
          const Cell origin{x * kBlock, y * kBlock, z * kBlock};
          // Tapered blobs change a little faster than the distance itself.
          if (std::abs(body_.distance(point(origin) + Vec3{half, half, half})) > 1.4 * reach) continue;
          block_at_[block_key(x, y, z)] = blocks_.size();
          blocks_.push_back({origin, {}, {}, {}});
        }
      }
    }
  }

  void fill(Block& block) const {
    const double half = 0.5 * kBlock * cell_;
    const Vec3 center = point(block.origin) + Vec3{half, half, half};
    const ImplicitBody local = body_.near(center, 1.4 * std::sqrt(3.0) * half);
    block.distance.reserve(flat(0, 0, kPoints, kPoints));
    for (int z = 0; z < kPoints; ++z) {
      for (int y = 0; y < kPoints; ++y) {
        for (int x = 0; x < kPoints; ++x)
          block.distance.push_back(
              local.distance(point({block.origin.x + x, block.origin.y + y, block.origin.z + z})));
      }
    }
    block.vertex_of.assign(flat(0, 0, kBlock, kBlock), kNoVertex);
    for (int z = 0; z < kBlock; ++z) {
      for (int y = 0; y < kBlock; ++y) {
        for (int x = 0; x < kBlock; ++x) add_vertex(block, local, {x, y, z});
      }
    }
  }

  /// The mean of the points where the cell's edges cross the surface, moved onto it.
  void add_vertex(Block& block, const ImplicitBody& local, Cell c) const {
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
    if (crossings == 0) return;
    Vec3 p = sum * (1.0 / crossings) + (point(block.origin) - lower_);
    for (int iteration = 0; iteration < 2; ++iteration) {
      const Vec3 g = local.gradient(p, 0.1 * cell_);
      const double squared = std::max(dot(g, g), 0.05);
      const double move = std::clamp(local.distance(p) / squared, -0.5 * cell_, 0.5 * cell_);
      p = p - g * move;
    }
    block.vertex_of[flat(c.x, c.y, c.z, kBlock)] = static_cast<std::uint32_t>(block.vertices.size());
    block.vertices.push_back(p);
  }

  std::uint32_t vertex(Cell c) const {
    if (c.x < 0 || c.y < 0 || c.z < 0) return kNoVertex;
    const auto found = block_at_.find(block_key(c.x / kBlock, c.y / kBlock, c.z / kBlock));
    if (found == block_at_.end()) return kNoVertex;
    return blocks_[found->second].vertex_of[flat(c.x % kBlock, c.y % kBlock, c.z % kBlock, kBlock)];
  }

  /// Two triangles about each lattice edge of the block that crosses the surface.
  void add_faces(const Block& block, Shape& shape) const {
    for (int z = 0; z < kBlock; ++z) {
      for (int y = 0; y < kBlock; ++y) {
        for (int x = 0; x < kBlock; ++x) {
          const bool inside = block.at(x, y, z) < 0;
          const Cell c{block.origin.x + x, block.origin.y + y, block.origin.z + z};
          if (inside != (block.at(x + 1, y, z) < 0)) add_face(shape, c, {0, 1, 0}, {0, 0, 1}, inside);
          if (inside != (block.at(x, y + 1, z) < 0)) add_face(shape, c, {0, 0, 1}, {1, 0, 0}, inside);
          if (inside != (block.at(x, y, z + 1) < 0)) add_face(shape, c, {1, 0, 0}, {0, 1, 0}, inside);
        }
      }
    }
  }

  void add_face(Shape& shape, Cell c, Cell u, Cell v, bool outward) const {
    std::uint32_t q[4] = {vertex({c.x - u.x - v.x, c.y - u.y - v.y, c.z - u.z - v.z}),
                          vertex({c.x - v.x, c.y - v.y, c.z - v.z}), vertex(c),
                          vertex({c.x - u.x, c.y - u.y, c.z - u.z})};
    if (std::find(std::begin(q), std::end(q), kNoVertex) != std::end(q)) return;
    if (!outward) std::swap(q[1], q[3]);
    const auto diagonal = [&](int i, int j) { return length(shape.positions[q[i]] - shape.positions[q[j]]); };
    const int turn = diagonal(0, 2) <= diagonal(1, 3) ? 0 : 1;
    for (const int i : {0, 1, 2, 0, 2, 3}) shape.indices.push_back(q[(i + turn) % 4]);
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
  return SurfaceNet(body, cell).run();
}

Shape polygonise_to_count(const ImplicitBody& body, std::size_t triangles) {
  Vec3 lower, upper;
  body.bounds(lower, upper);
  double cell = length(upper - lower) / 60;
  Shape best;
  double best_miss = std::numeric_limits<double>::infinity();
  // The count goes with 1 / cell^2; a coarse first try measures the surface.
  for (int attempt = 0; attempt < 6 && best_miss > 0.01; ++attempt) {
    Shape shape = polygonise(body, cell);
    const double ratio = static_cast<double>(shape.triangle_count()) / static_cast<double>(triangles);
    const double miss = ratio > 0 ? std::abs(std::log(ratio)) : best_miss;
    if (miss < best_miss) {
      best_miss = miss;
      best = std::move(shape);
    }
    // Cells larger than the body find nothing of it.
    cell *= ratio > 0 ? std::sqrt(ratio) : 0.6;
  }
  return best;
}

}  // namespace stbvh::harness
