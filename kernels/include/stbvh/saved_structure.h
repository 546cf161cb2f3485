/// Structures in files: built once, there again in the time that it takes to read them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "stbvh/mesh_view.h"
#include "stbvh/structure.h"

namespace stbvh {

/// Thrown for a file that holds no structure that this library can take; what() says why, in a few words
/// behind the file's name ("is truncated").
struct BadStructureFile : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct SaveOptions {
  /// The meshes' triangles and positions too. Without them only meshes of the same contents can be given the
  /// structure again.
  bool with_buffers = true;
  /// Whatever the caller wants to find in the file.
  std::span<const std::byte> user_data = {};
};

/// Hands the bytes of a file to `write`, piece by piece, in order. `meshes` are those that the structure was
/// built of or last updated to.
void save_structure(const Structure& structure, std::span<const MeshView> meshes, const SaveOptions& options,
                    const std::function<void(std::span<const std::byte>)>& write);

/// A file made by save_structure(). It is mapped, not read: what it holds is in memory once it is used,
/// shared with other processes, and must not be changed while it is used. Everything is checked first
/// (checksums of 1 MB each, on all threads; every link, index and time of the tree): no file can make rays
/// read where they should not.
class SavedStructure {
 public:
  /// Throws BadStructureFile, and std::system_error where the file cannot be mapped.
  explicit SavedStructure(const std::filesystem::path& file);
  /// The same in memory, which is copied.
  explicit SavedStructure(std::span<const std::byte> bytes);
  ~SavedStructure();
  SavedStructure(SavedStructure&&) noexcept;
  SavedStructure& operator=(SavedStructure&&) noexcept;

  /// With which it was built.
  BuildSettings settings() const;
  bool has_buffers() const;
  /// As they were saved; their buffers lie in the file as long as this lives. Without buffers their pointers
  /// are null.
  std::span<const MeshView> meshes() const;
  std::span<const std::byte> user_data() const;

  /// The structure over `meshes`, or over meshes(); it keeps the file by itself, but not its buffers. Only
  /// masks and geom_ids may differ from what was saved: throws BadStructureFile for meshes of other contents,
  /// or without any.
  std::unique_ptr<Structure> structure() const;
  std::unique_ptr<Structure> structure(std::span<const MeshView> meshes) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stbvh
