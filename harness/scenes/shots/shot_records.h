/// The records that scripts hand over: handover.py writes them, and says how.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "harness/files/input_file.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/subdivision/subdivision.h"

namespace stbvh::harness::shots {

/// Records that no script of ours writes; what() says what is wrong with them.
struct BadRecord : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class Tag : std::uint32_t { kEnd, kMesh, kCamera, kSun, kSky, kWarning, kProblem };

/// Polygons and their motion, or a cage: the steps stand in `cage` for either.
struct MeshRecord {
  std::string name;
  bool is_cage = false;
  SubdivisionCage cage;
  std::vector<float> step_times;  ///< of each step; none of one
  Material material;
};

class RecordFile {
 public:
  /// Throws InputFileError, and BadRecord for what does not begin as such a file.
  explicit RecordFile(const std::filesystem::path& path);

  /// Goes to the next record; false behind the last that is whole.
  bool next();
  Tag tag() const { return tag_; }

  // What the record holds. Counts are held against its size before any memory is taken. Throw BadRecord.
  MeshRecord mesh();
  std::vector<Camera> camera();
  DirectionalLight sun();
  Vec3f sky();
  std::string text();

 private:
  std::size_t left() const { return end_ - at_; }
  void read(void* to, std::size_t bytes);
  template <class T>
  T number();
  template <class T>
  std::vector<T> numbers(std::uint64_t count);
  std::size_t checked_count(std::uint64_t count, std::size_t bytes_each) const;
  Vec3f vector();
  std::string name(std::uint32_t bytes);

  InputFile file_;
  std::size_t at_ = 0, end_ = 0;  ///< what is left of the record
  Tag tag_ = Tag::kEnd;
};

}  // namespace stbvh::harness::shots
