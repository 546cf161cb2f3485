/// A meshlet: a small connected group of triangles, what a leaf holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "builder/build_memory.h"
#include "layout/layout.h"

namespace stbvh {

/// Up to eight triangles of one mesh over up to eight vertices.
struct Meshlet {
  std::uint8_t triangle_count;
  std::uint8_t vertex_count;
  std::uint8_t corners[3][kWidth];
  std::uint32_t prims[kWidth];
  std::uint32_t vertices[kWidth];

  std::span<const std::uint32_t> used_vertices() const { return {vertices, vertex_count}; }
};

/// Those of one mesh.
struct MeshletSet {
  std::unique_ptr<TemporaryArray<Meshlet>> storage;  ///< null: there are none
  std::size_t triangles = 0;                         ///< in all of them: the valid ones
  std::size_t invalid_triangles = 0;                 ///< left out

  std::span<const Meshlet> meshlets() const {
    return storage == nullptr ? std::span<const Meshlet>() : storage->span();
  }
};

}  // namespace stbvh
