/// How the weights of a refinement are had from OpenSubdiv, which applies them at once.
#pragma once

#include <cstddef>
#include <vector>

#include "harness/scenes/subdivision/cage_topology.h"

namespace stbvh::harness::subdivision {

/// What Far::PrimvarRefiner takes for the values of a level that it works out: it writes down the weights.
/// Vertices are worked out in ascending order; those that are not asked for are passed over.
class WeightRecorder {
 public:
  /// One of the vertices.
  class Row {
   public:
    Row(WeightRecorder& recorder, int vertex)
        : recorder_(recorder), vertex_(static_cast<std::size_t>(vertex)) {}

    void Clear() { recorder_.end_row(vertex_); }
    /// Of a vertex of the level before.
    void AddWithWeight(std::size_t vertex, double weight) {
      recorder_.add(vertex_, recorder_.own_ + vertex, weight);
    }
    /// Of one of the same level.
    void AddWithWeight(const Row& other, double weight) { recorder_.add(vertex_, other.vertex_, weight); }

   private:
    WeightRecorder& recorder_;
    std::size_t vertex_;
  };

  /// Others of the level use only the first `own` vertices.
  explicit WeightRecorder(std::vector<bool> is_used, std::size_t own = 0);

  Row operator[](int vertex) { return Row(*this, vertex); }
  WeightedSums take();

 private:
  void add(std::size_t row, std::size_t column, double weight);
  /// Closes the row of the last vertex that was asked for, before `next` begins.
  void end_row(std::size_t next);

  std::vector<bool> is_used_;
  std::size_t own_;
  WeightedSums sums_;
  bool is_open_ = false;
};

}  // namespace stbvh::harness::subdivision
