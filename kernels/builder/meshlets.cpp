#include "builder/meshlets.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "builder/mbsah.h"

namespace stbvh {

namespace {

/// Triangles are sorted along a space-filling curve and grouped in runs of this many, each on its own.
constexpr std::size_t kRun = 8192;
constexpr std::size_t kChunk = 8192;
constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// Two times at which the size of a meshlet is measured.
constexpr std::size_t kSamples = 2;

std::array<std::size_t, kSamples> sampled_steps(const BuildMesh& mesh) {
  const std::size_t segments = mesh.segments();
  return {segments / 3, (2 * segments + 2) / 3};
}

struct SortedTriangle {
  std::uint64_t key;  ///< along the curve
  std::uint32_t prim;

  bool operator<(const SortedTriangle& other) const {
    return key != other.key ? key < other.key : prim < other.prim;
  }
};

/// The lower 21 bits of `x`, two zeros between each two.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1F00000000FFFFu;
  x = (x | x << 16) & 0x1F0000FF0000FFu;
  x = (x | x << 8) & 0x100F00F00F00F00Fu;
  x = (x | x << 4) & 0x10C30C30C30C30C3u;
  x = (x | x << 2) & 0x1249249249249249u;
  return x;
}

/// A hash table from 64-bit keys to indices, open addressing; sized for `count` entries.
class IndexTable {
 public:
  explicit IndexTable(std::size_t count)
      : mask_(std::bit_ceil(std::max<std::size_t>(2 * count, 2)) - 1), slots_(mask_ + 1, kNone) {}

  /// The first index in the chain of `hash` for which `same(index)`; otherwise `added` is entered.
  template <typename Same>
  std::uint32_t find_or_add(std::uint64_t hash, std::uint32_t added, const Same& same) {
    std::size_t slot = (hash * 0x9E3779B97F4A7C15u >> 32) & mask_;
    while (slots_[slot] != kNone) {
      if (same(slots_[slot])) return slots_[slot];
      slot = (slot + 1) & mask_;
    }
    return slots_[slot] = added;
  }

 private:
  std::size_t mask_;
  std::vector<std::uint32_t> slots_;
};

bool same_position(const BuildMesh& mesh, std::uint32_t a, std::uint32_t b) {
  for (std::size_t step = 0; step <= mesh.segments(); ++step) {
    const Vec3f p = mesh.position(step, a);
    const Vec3f q = mesh.position(step, b);
    if (std::memcmp(&p, &q, sizeof p) != 0) return false;
  }
  return true;
}

struct Boxes {
  F32x4 lower[kSamples], upper[kSamples];

  void extend(const Boxes& other) {
    for (std::size_t s = 0; s < kSamples; ++s) {
      lower[s] = min(lower[s], other.lower[s]);
      upper[s] = max(upper[s], other.upper[s]);
    }
  }
  float area() const {
    float sum = 0;
    for (std::size_t s = 0; s < kSamples; ++s) sum += half_area(upper[s] - lower[s]);
    return sum;
  }
};

Boxes united(Boxes a, const Boxes& b) {
  a.extend(b);
  return a;
}

/// Groups one run of triangles.
class Grouping {
 public:
  /// At most, of all that is kept while a run is grouped.
  static constexpr std::size_t kBytesPerTriangle = 384;

  Grouping(const BuildMesh& mesh, std::span<const SortedTriangle> run) : mesh_(mesh), run_(run) {
    number_vertices();
    find_neighbours();
    used_.resize(run.size());
    seen_.assign(run.size(), kNone);
    vertex_group_.assign(vertices_.size(), kNone);
    vertex_slot_.resize(vertices_.size());
  }

  std::vector<Meshlet> group() {
    std::size_t next = 0;
    for (;;) {
      std::uint32_t seed = neighbouring_seed();
      if (seed == kNone) {
        while (next < run_.size() && used_[next]) ++next;
        if (next == run_.size()) break;
        seed = static_cast<std::uint32_t>(next);
      }
      grow(seed);
    }
    merge_small();
    return std::move(meshlets_);
  }

 private:
  using Corners = std::array<std::uint32_t, 3>;

  void number_vertices() {
    IndexTable by_id(3 * run_.size());
    IndexTable by_position(3 * run_.size());
    const auto steps = sampled_steps(mesh_);
    corners_.resize(run_.size());
    std::vector<std::uint32_t> canonical;
    for (std::size_t i = 0; i < run_.size(); ++i) {
      const BuildMesh::Triangle t = mesh_.triangle(run_[i].prim);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = t.vertex[corner];
        const auto added = static_cast<std::uint32_t>(ids_.size());
        const std::uint32_t id =
            by_id.find_or_add(vertex, added, [&](std::uint32_t k) { return ids_[k] == vertex; });
        if (id == added) {
          ids_.push_back(vertex);
          canonical.push_back(canonical_vertex(by_position, vertex, steps));
        }
        corners_[i][corner] = canonical[id];
      }
    }
  }

  std::uint32_t canonical_vertex(IndexTable& by_position, std::uint32_t vertex,
                                 const std::array<std::size_t, kSamples>& steps) {
    // Vertices may coincide at some steps only: where all that can move start, for example.
    std::uint64_t hash = 0;
    for (const std::size_t step : {std::size_t{0}, steps[0], steps[1], mesh_.segments()}) {
      const Vec3f p = mesh_.position(step, vertex);
      for (const float x : {p.x, p.y, p.z}) {
        hash = (hash ^ std::bit_cast<std::uint32_t>(x)) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
      }
    }
    const auto added = static_cast<std::uint32_t>(vertices_.size());
    const std::uint32_t index = by_position.find_or_add(
        hash, added, [&](std::uint32_t k) { return same_position(mesh_, vertices_[k], vertex); });
    if (index == added) {
      vertices_.push_back(vertex);
      for (std::size_t s = 0; s < kSamples; ++s)
        positions_[s].push_back(F32x4(mesh_.position(steps[s], vertex)));
    }
    return index;
  }

  void find_neighbours() {
    first_.assign(vertices_.size() + 1, 0);
    for (const Corners& c : corners_) {
      for (const std::uint32_t v : c) ++first_[v + 1];
    }
    live_.assign(first_.begin() + 1, first_.end());
    for (std::size_t v = 0; v < vertices_.size(); ++v) first_[v + 1] += first_[v];
    triangles_.resize(first_.back());
    end_.assign(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      for (const std::uint32_t v : corners_[i]) triangles_[end_[v]++] = static_cast<std::uint32_t>(i);
    }
  }

  Boxes boxes_of(std::uint32_t triangle) const {
    const Corners& c = corners_[triangle];
    Boxes b;
    for (std::size_t s = 0; s < kSamples; ++s) {
      const F32x4 p0 = positions_[s][c[0]], p1 = positions_[s][c[1]], p2 = positions_[s][c[2]];
      b.lower[s] = min(min(p0, p1), p2);
      b.upper[s] = max(max(p0, p1), p2);
    }
    return b;
  }

  /// Unused triangles that share a vertex with it, counted once for each vertex.
  std::uint32_t live_neighbours(std::uint32_t triangle) const {
    const Corners& c = corners_[triangle];
    return live_[c[0]] + live_[c[1]] + live_[c[2]];
  }

  /// Next to the last group, the triangle with the fewest neighbours left: no islands stay behind.
  std::uint32_t neighbouring_seed() const {
    std::uint32_t best = kNone, fewest = kNone;
    for (const std::uint32_t t : candidates_) {
      if (used_[t]) continue;
      const std::uint32_t live = live_neighbours(t);
      if (live < fewest) {
        fewest = live;
        best = t;
      }
    }
    return best;
  }

  std::uint32_t new_vertices(std::uint32_t triangle, std::uint32_t group) const {
    const Corners& c = corners_[triangle];
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      bool known = vertex_group_[c[i]] == group;
      for (std::size_t j = 0; j < i; ++j) known = known || c[j] == c[i];
      count += !known;
    }
    return count;
  }

  void add(Meshlet& m, std::uint32_t triangle, std::uint32_t group) {
    used_[triangle] = 1;
    const std::size_t i = m.triangle_count++;
    m.prims[i] = run_[triangle].prim;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = corners_[triangle][corner];
      --live_[v];
      if (vertex_group_[v] != group) {
        vertex_group_[v] = group;
        vertex_slot_[v] = m.vertex_count;
        m.vertices[m.vertex_count++] = vertices_[v];
        add_candidates(v, group);
      }
      m.corners[corner][i] = vertex_slot_[v];
    }
  }

  /// Unused triangles at a vertex; not all of them where thousands meet.
  void add_candidates(std::uint32_t vertex, std::uint32_t group) {
    while (first_[vertex] < end_[vertex] && used_[triangles_[first_[vertex]]]) ++first_[vertex];
    for (std::uint32_t k = first_[vertex]; k < end_[vertex] && candidates_.size() < kMostCandidates; ++k) {
      const std::uint32_t t = triangles_[k];
      if (used_[t] || seen_[t] == group) continue;
      seen_[t] = group;
      candidates_.push_back(t);
    }
  }

  void grow(std::uint32_t seed) {
    const auto group = static_cast<std::uint32_t>(meshlets_.size());
    Meshlet& m = meshlets_.emplace_back();
    candidates_.clear();
    Boxes boxes = boxes_of(seed);
    float area = boxes.area();
    add(m, seed, group);
    while (m.triangle_count < kWidth) {
      std::uint32_t best = kNone;
      float best_score = std::numeric_limits<float>::infinity();
      float best_area = 0;
      std::size_t kept = 0;
      for (const std::uint32_t t : candidates_) {
        if (used_[t]) continue;
        candidates_[kept++] = t;
        const std::uint32_t extra = new_vertices(t, group);
        if (m.vertex_count + extra > kWidth) continue;
        const Boxes own = boxes_of(t);
        const float grown = united(boxes, own).area();
        const float alone = own.area();
        if (grown * (1.0f - kSplitCost) > area + alone) continue;
        const auto live = static_cast<float>(live_neighbours(t) - 2);
        const float score =
            grown * (1.0f + kVertexWeight * static_cast<float>(extra)) - kOrphanWeight * alone / live;
        if (score < best_score) {
          best_score = score;
          best = t;
          best_area = grown;
        }
      }
      candidates_.resize(kept);
      if (best == kNone) break;
      boxes.extend(boxes_of(best));
      area = best_area;
      add(m, best, group);
    }
    group_boxes_.push_back(boxes);
  }

  /// The triangles of both, if a leaf has room for them; vertices in common count once.
  static std::optional<Meshlet> joined(const Meshlet& a, const Meshlet& b) {
    if (a.triangle_count + b.triangle_count > kWidth) return std::nullopt;
    Meshlet m = a;
    std::uint8_t slots[kWidth];
    for (std::size_t i = 0; i < b.vertex_count; ++i) {
      std::uint8_t slot = 0;
      while (slot < m.vertex_count && m.vertices[slot] != b.vertices[i]) ++slot;
      if (slot == kWidth) return std::nullopt;
      if (slot == m.vertex_count) m.vertices[m.vertex_count++] = b.vertices[i];
      slots[i] = slot;
    }
    for (std::size_t i = 0; i < b.triangle_count; ++i) {
      m.prims[m.triangle_count] = b.prims[i];
      for (std::size_t corner = 0; corner < 3; ++corner)
        m.corners[corner][m.triangle_count] = slots[b.corners[corner][i]];
      ++m.triangle_count;
    }
    return m;
  }

  /// Small groups that are left over join others of the next few in the run, where that pays.
  void merge_small() {
    std::vector<std::uint32_t> small;
    for (std::uint32_t g = 0; g < meshlets_.size(); ++g) {
      if (meshlets_[g].vertex_count < kWidth && meshlets_[g].triangle_count < kWidth) small.push_back(g);
    }
    for (std::size_t i = 0; i < small.size(); ++i) {
      if (meshlets_[small[i]].triangle_count == 0) continue;
      for (;;) {
        Meshlet& m = meshlets_[small[i]];
        Boxes& boxes = group_boxes_[small[i]];
        const float area = boxes.area();
        std::uint32_t best = kNone;
        std::optional<Meshlet> best_joined;
        float best_gain = 0;
        for (std::size_t j = i + 1; j < std::min(small.size(), i + kMergeWindow); ++j) {
          const Meshlet& other = meshlets_[small[j]];
          if (other.triangle_count == 0) continue;
          const Boxes& others = group_boxes_[small[j]];
          const float gain = area + others.area() - united(boxes, others).area() * (1.0f - kSplitCost);
          if (!(gain > best_gain)) continue;
          if (const std::optional<Meshlet> both = joined(m, other)) {
            best_gain = gain;
            best = small[j];
            best_joined = both;
          }
        }
        if (!best_joined) break;
        m = *best_joined;
        boxes.extend(group_boxes_[best]);
        meshlets_[best].triangle_count = 0;
      }
    }
    std::erase_if(meshlets_, [](const Meshlet& m) { return m.triangle_count == 0; });
  }

  static constexpr std::size_t kMergeWindow = 16;
  static constexpr std::size_t kMostCandidates = 64;

  const BuildMesh& mesh_;
  std::span<const SortedTriangle> run_;
  std::vector<std::uint32_t> ids_;       ///< vertices of the mesh met so far
  std::vector<std::uint32_t> vertices_;  ///< those of them that differ in position
  std::vector<F32x4> positions_[kSamples];
  std::vector<Corners> corners_;            ///< of each triangle, as indices into vertices_
  std::vector<std::uint32_t> triangles_;    ///< of all vertices
  std::vector<std::uint32_t> first_, end_;  ///< those of each vertex that may be unused
  std::vector<std::uint32_t> live_;         ///< unused triangles of each vertex
  std::vector<std::uint8_t> used_;
  std::vector<std::uint32_t> seen_;  ///< the last group that a triangle was a candidate of
  std::vector<std::uint32_t> vertex_group_;
  std::vector<std::uint8_t> vertex_slot_;
  std::vector<std::uint32_t> candidates_;
  std::vector<Meshlet> meshlets_;
  std::vector<Boxes> group_boxes_;
};

/// The valid triangles of a mesh along a space-filling curve through their centroids at one step.
class TriangleOrder {
 public:
  TriangleOrder(BuildContext& context, const BuildMesh& mesh)
      : mesh_(mesh), step_(sampled_steps(mesh)[0]), storage_(context.memory, mesh.view().triangle_count) {
    collect_valid();
    context.progress.check();
    set_keys();
    tbb::parallel_sort(triangles_.begin(), triangles_.end());
    context.progress.check();
  }
  std::span<const SortedTriangle> triangles() const { return triangles_; }

 private:
  F32x4 centroid3(std::uint32_t prim) const {
    const BuildMesh::Triangle t = mesh_.triangle(prim);
    return F32x4(mesh_.position(step_, t.vertex[0])) + F32x4(mesh_.position(step_, t.vertex[1])) +
           F32x4(mesh_.position(step_, t.vertex[2]));
  }

  void collect_valid() {
    struct Chunk {
      std::size_t count = 0;
      F32x4 lower{std::numeric_limits<float>::infinity()};
      F32x4 upper{-std::numeric_limits<float>::infinity()};
    };
    const std::size_t count = mesh_.view().triangle_count;
    std::vector<Chunk> chunks((count + kChunk - 1) / kChunk);
    tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) {
      Chunk chunk;
      for (std::size_t prim = i * kChunk; prim < std::min((i + 1) * kChunk, count); ++prim) {
        if (!mesh_.is_valid(mesh_.triangle(prim))) continue;
        const F32x4 c = centroid3(static_cast<std::uint32_t>(prim));
        chunk.lower = min(chunk.lower, c);
        chunk.upper = max(chunk.upper, c);
        storage_.data()[i * kChunk + chunk.count++].prim = static_cast<std::uint32_t>(prim);
      }
      chunks[i] = chunk;
    });
    std::size_t valid = 0;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      std::memmove(storage_.data() + valid, storage_.data() + i * kChunk,
                   chunks[i].count * sizeof(SortedTriangle));
      valid += chunks[i].count;
      lower_ = min(lower_, chunks[i].lower);
      upper_ = max(upper_, chunks[i].upper);
    }
    triangles_ = storage_.span().first(valid);
  }

  void set_keys() {
    const F32x4 extent = upper_ - lower_;
    const float scale = 0x1.FFFFp20f / std::max({extent[0], extent[1], extent[2]});
    const F32x4 scale4(std::isfinite(scale) ? scale : 0.0f);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles_.size(), kChunk), [&](const auto& part) {
      for (std::size_t i = part.begin(); i != part.end(); ++i) {
        const F32x4 c = (centroid3(triangles_[i].prim) - lower_) * scale4;
        std::uint64_t key = 0;
        for (int axis = 0; axis < 3; ++axis) key |= spread(static_cast<std::uint64_t>(c[axis])) << axis;
        triangles_[i].key = key;
      }
    });
  }

  const BuildMesh& mesh_;
  std::size_t step_;
  TemporaryArray<SortedTriangle> storage_;
  std::span<SortedTriangle> triangles_;
  F32x4 lower_{std::numeric_limits<float>::infinity()};
  F32x4 upper_{-std::numeric_limits<float>::infinity()};
};

}  // namespace

MeshletSet make_meshlets(BuildContext& context, const BuildMesh& mesh) {
  MeshletSet set;
  if (mesh.view().triangle_count == 0) return set;
  const TriangleOrder order(context, mesh);
  const std::span<const SortedTriangle> triangles = order.triangles();
  set.triangles = triangles.size();
  set.invalid_triangles = mesh.view().triangle_count - triangles.size();
  if (triangles.empty()) return set;

  using Array = TemporaryArray<Meshlet>;
  std::vector<std::unique_ptr<Array>> runs((triangles.size() + kRun - 1) / kRun);
  tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t i) {
    context.progress.check();
    const std::size_t begin = i * kRun;
    const std::size_t count = std::min(kRun, triangles.size() - begin);
    const CountedMemory counted(context.memory, count * Grouping::kBytesPerTriangle);
    Grouping grouping(mesh, triangles.subspan(begin, count));
    const std::vector<Meshlet> meshlets = grouping.group();
    runs[i] = std::make_unique<Array>(context.memory, meshlets.size());
    std::copy(meshlets.begin(), meshlets.end(), runs[i]->data());
  });
  for (const auto& run : runs) {
    if (run == nullptr) throw BuildCancelled();  // tasks were skipped: another mesh has thrown
  }
  if (runs.size() == 1) {
    set.storage = std::move(runs[0]);
    return set;
  }
  std::size_t count = 0;
  for (const auto& run : runs) count += run->span().size();
  set.storage = std::make_unique<Array>(context.memory, count);
  Meshlet* out = set.storage->data();
  for (auto& run : runs) {
    out = std::copy(run->span().begin(), run->span().end(), out);
    run.reset();
  }
  return set;
}

}  // namespace stbvh
