#include "builder/meshlet_grouping.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "builder/mbsah.h"

namespace stbvh {

namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;
constexpr std::size_t kMergeWindow = 16;
constexpr std::size_t kMostCandidates = 64;

using Boxes = std::array<Box4, kSamples>;

void extend(Boxes& boxes, const Boxes& others) {
  for (std::size_t s = 0; s < kSamples; ++s) boxes[s].extend(others[s]);
}

float area_of(const Boxes& boxes) {
  float sum = 0;
  for (const Box4& box : boxes) sum += half_area(box.upper - box.lower);
  return sum;
}

float area_of_both(Boxes a, const Boxes& b) {
  extend(a, b);
  return area_of(a);
}

/// The triangles of both, if a leaf has room for them; vertices in common count once.
std::optional<Meshlet> joined(const Meshlet& a, const Meshlet& b) {
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

}  // namespace

MeshletGrouping::MeshletGrouping(const BuildMesh& mesh, std::span<const SortedTriangle> run)
    : run_(run), vertices_(mesh, run) {
  find_neighbours();
  used_.resize(run.size());
  seen_.assign(run.size(), kNone);
  vertex_group_.assign(vertices_.size(), kNone);
  vertex_slot_.resize(vertices_.size());
}

std::vector<Meshlet> MeshletGrouping::group() {
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

void MeshletGrouping::find_neighbours() {
  first_.assign(vertices_.size() + 1, 0);
  for (const TriangleIndices& c : vertices_.corners()) {
    for (const std::uint32_t v : c) ++first_[v + 1];
  }
  live_.assign(first_.begin() + 1, first_.end());
  for (std::size_t v = 0; v < vertices_.size(); ++v) first_[v + 1] += first_[v];
  triangles_.resize(first_.back());
  end_.assign(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < run_.size(); ++i) {
    for (const std::uint32_t v : vertices_.corners(i)) triangles_[end_[v]++] = static_cast<std::uint32_t>(i);
  }
}

MeshletGrouping::Boxes MeshletGrouping::boxes_of(std::uint32_t triangle) const {
  const TriangleIndices& c = vertices_.corners(triangle);
  Boxes b;
  for (std::size_t s = 0; s < kSamples; ++s) {
    const auto corner = [&](std::size_t i) { return vertices_.position(s, c[i]); };
    b[s] = {corner(0), corner(0)};
    b[s].extend(corner(1));
    b[s].extend(corner(2));
  }
  return b;
}

/// Unused triangles that share a vertex with it, counted once for each vertex.
std::uint32_t MeshletGrouping::live_neighbours(std::uint32_t triangle) const {
  const TriangleIndices& c = vertices_.corners(triangle);
  return live_[c[0]] + live_[c[1]] + live_[c[2]];
}

/// Next to the last group, the triangle with the fewest neighbours left: no islands stay behind.
std::uint32_t MeshletGrouping::neighbouring_seed() const {
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

std::uint32_t MeshletGrouping::new_vertices(std::uint32_t triangle, std::uint32_t group) const {
  const TriangleIndices& c = vertices_.corners(triangle);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    bool known = vertex_group_[c[i]] == group;
    for (std::size_t j = 0; j < i; ++j) known = known || c[j] == c[i];
    count += !known;
  }
  return count;
}

void MeshletGrouping::add(Meshlet& m, std::uint32_t triangle, std::uint32_t group) {
  used_[triangle] = 1;
  const std::size_t i = m.triangle_count++;
  m.prims[i] = run_[triangle].prim;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t v = vertices_.corners(triangle)[corner];
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
void MeshletGrouping::add_candidates(std::uint32_t vertex, std::uint32_t group) {
  while (first_[vertex] < end_[vertex] && used_[triangles_[first_[vertex]]]) ++first_[vertex];
  for (std::uint32_t k = first_[vertex]; k < end_[vertex] && candidates_.size() < kMostCandidates; ++k) {
    const std::uint32_t t = triangles_[k];
    if (used_[t] || seen_[t] == group) continue;
    seen_[t] = group;
    candidates_.push_back(t);
  }
}

void MeshletGrouping::grow(std::uint32_t seed) {
  const auto group = static_cast<std::uint32_t>(meshlets_.size());
  Meshlet& m = meshlets_.emplace_back();
  candidates_.clear();
  Boxes boxes = boxes_of(seed);
  float area = area_of(boxes);
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
      const float grown = area_of_both(boxes, own);
      const float alone = area_of(own);
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
    extend(boxes, boxes_of(best));
    area = best_area;
    add(m, best, group);
  }
  group_boxes_.push_back(boxes);
}

/// Small groups that are left over join others of the next few in the run, where that pays.
void MeshletGrouping::merge_small() {
  std::vector<std::uint32_t> small;
  for (std::uint32_t g = 0; g < meshlets_.size(); ++g) {
    if (meshlets_[g].vertex_count < kWidth && meshlets_[g].triangle_count < kWidth) small.push_back(g);
  }
  for (std::size_t i = 0; i < small.size(); ++i) {
    if (meshlets_[small[i]].triangle_count == 0) continue;
    for (;;) {
      Meshlet& m = meshlets_[small[i]];
      Boxes& boxes = group_boxes_[small[i]];
      const float area = area_of(boxes);
      std::uint32_t best = kNone;
      std::optional<Meshlet> best_joined;
      float best_gain = 0;
      for (std::size_t j = i + 1; j < std::min(small.size(), i + kMergeWindow); ++j) {
        const Meshlet& other = meshlets_[small[j]];
        if (other.triangle_count == 0) continue;
        const Boxes& others = group_boxes_[small[j]];
        const float gain = area + area_of(others) - area_of_both(boxes, others) * (1.0f - kSplitCost);
        if (!(gain > best_gain)) continue;
        if (const std::optional<Meshlet> both = joined(m, other)) {
          best_gain = gain;
          best = small[j];
          best_joined = both;
        }
      }
      if (!best_joined) break;
      m = *best_joined;
      extend(boxes, group_boxes_[best]);
      meshlets_[best].triangle_count = 0;
    }
  }
  std::erase_if(meshlets_, [](const Meshlet& m) { return m.triangle_count == 0; });
}

}  // namespace stbvh
