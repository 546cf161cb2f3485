#include "stbvh/mesh_fingerprint.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "content_hash.h"
#include "isolated.h"

namespace stbvh {
namespace {

constexpr std::size_t kChunk = 65536;  ///< elements that one thread reads

/// Elements of a buffer, `stride` bytes apart.
struct Elements {
  const void* data;
  std::size_t count, stride;

  std::size_t chunks() const { return (count + kChunk - 1) / kChunk; }
};

ContentHash hash_of(const Elements& elements, std::size_t chunk) {
  const std::size_t first = chunk * kChunk;
  ContentHasher hasher;
  for_each_piece(static_cast<const std::byte*>(elements.data) + first * elements.stride,
                 std::min(kChunk, elements.count - first), elements.stride,
                 [&](std::span<const std::byte> bytes) { hasher.add(bytes); });
  return hasher.hash();
}

Elements triangles_of(const MeshView& mesh) {
  return {mesh.indices, mesh.triangle_count, mesh.index_stride};
}

/// Of everything but the buffers' contents.
ContentHash frame_of(const MeshView& mesh) {
  std::vector<std::uint32_t> words;
  const auto add_count = [&](std::size_t count) {
    words.push_back(static_cast<std::uint32_t>(count));
    words.push_back(static_cast<std::uint32_t>(count >> 32));
  };
  const auto add_time = [&](float time) {
    words.emplace_back();
    std::memcpy(&words.back(), &time, sizeof time);
  };
  add_count(mesh.triangle_count);
  add_count(mesh.steps.size());
  add_count(mesh.steps.empty() ? 0 : mesh.steps[0].count);
  add_count(mesh.step_times.size());
  add_time(mesh.time_range.begin);
  add_time(mesh.time_range.end);
  for (const float time : mesh.step_times) add_time(time);
  return stbvh::hash_of(std::as_bytes(std::span(words)));
}

}  // namespace

std::vector<MeshFingerprint> fingerprints_of(std::span<const MeshView> meshes) {
  struct Piece {
    Elements elements;
    std::size_t chunk;
  };
  std::vector<Piece> pieces;
  const auto add = [&](const Elements& elements) {
    for (std::size_t chunk = 0; chunk < elements.chunks(); ++chunk) pieces.push_back({elements, chunk});
  };
  for (const MeshView& mesh : meshes) {
    add(triangles_of(mesh));
    for (const VertexBufferView& step : mesh.steps) add({step.data, step.count, step.stride});
  }
  std::vector<ContentHash> hashes(pieces.size());
  isolated([&] {
    tbb::parallel_for(std::size_t{0}, pieces.size(),
                      [&](std::size_t i) { hashes[i] = hash_of(pieces[i].elements, pieces[i].chunk); });
  });

  std::vector<MeshFingerprint> fingerprints;
  auto next = hashes.begin();
  const auto joint = [&](std::vector<ContentHash> parts, std::size_t count) {
    parts.insert(parts.end(), next, next + static_cast<std::ptrdiff_t>(count));
    next += static_cast<std::ptrdiff_t>(count);
    return stbvh::hash_of(std::as_bytes(std::span(parts)));
  };
  for (const MeshView& mesh : meshes) {
    std::size_t chunks = 0;
    for (const VertexBufferView& step : mesh.steps)
      chunks += Elements{step.data, step.count, step.stride}.chunks();
    const ContentHash shape = joint({frame_of(mesh)}, triangles_of(mesh).chunks());
    fingerprints.push_back({shape, joint({}, chunks)});
  }
  return fingerprints;
}

MeshChange change_between(const MeshFingerprint& before, const MeshFingerprint& now) {
  if (before.shape != now.shape) return MeshChange::kAll;
  return before.positions == now.positions ? MeshChange::kNothing : MeshChange::kPositions;
}

}  // namespace stbvh
