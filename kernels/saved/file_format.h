/// What stands in the file of a saved structure, in the order of the machine (x86: little-endian).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "layout/node_slots.h"
#include "stbvh/mesh_fingerprint.h"

namespace stbvh {

inline constexpr std::array<char, 8> kFileMagic{'S', 'T', 'B', 'V', 'H', '\r', '\n', '\x1a'};
/// Of this format, and of the bytes of nodes and leaves (layout/layout.h): a change of either is another
/// version.
inline constexpr std::uint32_t kFileVersion = 1;
inline constexpr std::size_t kHeaderBytes = 4096;
inline constexpr std::size_t kHashedBytes = std::size_t{1} << 20;  ///< of each checksum

/// A part of the file, from a multiple of kHeaderBytes on.
struct FileSection {
  std::uint64_t offset = 0, bytes = 0;
};

struct FileHeader {
  std::array<char, 8> magic = kFileMagic;
  std::uint32_t version = kFileVersion;
  std::uint32_t is_empty = 0;
  std::uint64_t file_bytes = 0;
  FileSection block;    ///< nodes and leaves, as they lie in memory, the tree's in the order of a walk
  FileSection tables;   ///< meshes and records: saved/tables.h
  FileSection buffers;  ///< triangles and positions, 12 bytes each; empty: not with it
  FileSection user;
  FileSection hashes;               ///< of the parts above, kHashedBytes each from kHeaderBytes on
  std::uint64_t indexed_bytes = 0;  ///< of indexed leaves, at the end of the block
  std::uint64_t mesh_count = 0, record_count = 0;
  std::uint64_t max_bytes = 0, max_peak_bytes = 0;
  std::uint64_t wanted_bytes = 0, temporal_splits = 0;
  double usual_area = 0.0;
  float tolerance = 0.0f;
  std::uint32_t precision = 0;
  NodeSlot root{};
  std::uint32_t has_buffers = 0;
  ContentHash hash_of_hashes;
  ContentHash hash_of_header;  ///< with zeros here
};
static_assert(sizeof(FileHeader) == 272 && sizeof(NodeSlot) == 60);  // without gaps

}  // namespace stbvh
