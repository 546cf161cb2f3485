/// Bytes -> the file of a saved structure, its places and checksums put right -> rays through it, or the
/// refusal.
#include <algorithm>
#include <cstring>
#include <vector>

#include "kernels/saved/file_format.h"
#include "reader_input.h"
#include "stbvh/saved_structure.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace stbvh::fuzz {
namespace {

using File = std::vector<std::byte>;

ContentHash hash_of(const std::byte* data, std::size_t bytes) {
  const XXH128_hash_t hash = XXH3_128bits(data, bytes);
  return {hash.low64, hash.high64};
}

/// The header, the lengths of its four parts in 16 bits each, and the parts, one behind the other.
File unpacked(Bytes bytes) {
  FileHeader header;
  std::array<std::uint16_t, 4> lengths{};
  if (bytes.size() < sizeof header + sizeof lengths) return {};
  std::memcpy(static_cast<void*>(&header), bytes.data(), sizeof header);
  std::memcpy(lengths.data(), bytes.data() + sizeof header, sizeof lengths);
  bytes = bytes.subspan(sizeof header + sizeof lengths);
  File file(kHeaderBytes);
  FileSection* const sections[] = {&header.block, &header.tables, &header.buffers, &header.user};
  const auto pad = [&] { file.resize((file.size() + kHeaderBytes - 1) / kHeaderBytes * kHeaderBytes); };
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const std::size_t length = std::min<std::size_t>(lengths[i], bytes.size());
    *sections[i] = {file.size(), length};
    const auto part = std::as_bytes(bytes.first(length));
    file.insert(file.end(), part.begin(), part.end());
    bytes = bytes.subspan(length);
    pad();
  }
  std::vector<ContentHash> hashes;
  for (std::size_t first = kHeaderBytes; first < file.size(); first += kHashedBytes)
    hashes.push_back(hash_of(file.data() + first, std::min(kHashedBytes, file.size() - first)));
  header.hashes = {file.size(), hashes.size() * sizeof hashes[0]};
  const auto part = std::as_bytes(std::span(hashes));
  file.insert(file.end(), part.begin(), part.end());
  pad();
  header.file_bytes = file.size();
  header.hash_of_hashes = hash_of(part.data(), part.size());
  header.hash_of_header = {};
  header.hash_of_header = hash_of(reinterpret_cast<const std::byte*>(&header), sizeof header);
  std::memcpy(file.data(), &header, sizeof header);
  return file;
}

}  // namespace

void run(Bytes bytes) {
  const File file = unpacked(bytes);
  try {
    const SavedStructure saved(file);
    const auto structure = saved.structure();
    const Box3f box = structure->bounds_at(0.5f);
    for (int i = 0; i < 24; ++i) {
      const float share = static_cast<float>(i) / 23.0f;
      const Vec3f from{box.lower.x + share * (box.upper.x - box.lower.x), box.upper.y, box.upper.z + 1.0f};
      const Ray ray{from, 0.0f, {0.1f * share, -0.3f, -1.0f}, static_cast<float>(i % 9) / 8.0f, 1e30f};
      Hit hit;
      structure->intersect(ray, hit);
      structure->occluded(ray);
    }
  } catch (const BadStructureFile&) {
  } catch (const InvalidMesh&) {
  }
}

}  // namespace stbvh::fuzz
