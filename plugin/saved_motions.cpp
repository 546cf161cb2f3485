#include "plugin/saved_motions.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>

namespace stbvh::plugin {
namespace {

template <typename T>
void add(std::vector<std::byte>& bytes, const T* values, std::size_t count) {
  const auto* const first = reinterpret_cast<const std::byte*>(values);
  bytes.insert(bytes.end(), first, first + count * sizeof(T));
}

void add_count(std::vector<std::byte>& bytes, std::size_t count) {
  const auto number = static_cast<std::uint32_t>(count);
  add(bytes, &number, 1);
}

/// Takes values from the front; false: there are fewer.
class Taken {
 public:
  explicit Taken(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  bool take(std::vector<T>& values, std::size_t count) {
    if (count > bytes_.size() / sizeof(T)) return false;
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), bytes_.data(), count * sizeof(T));
    bytes_ = bytes_.subspan(count * sizeof(T));
    return true;
  }
  bool take_count(std::size_t& count) {
    std::vector<std::uint32_t> number;
    if (!take(number, 1)) return false;
    count = number[0];
    return true;
  }
  bool is_at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

bool take_motion(Taken& bytes, MeshMotion& motion) {
  std::size_t steps = 0, times = 0;
  if (!bytes.take_count(steps) || steps == 0 || !bytes.take(motion.steps, steps)) return false;
  if (!bytes.take_count(times) || (times != 0 && times != steps)) return false;
  if (!bytes.take(motion.step_times, times)) return false;
  const std::vector<float>& t = motion.step_times;
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (!is_usable({t[i - 1], t[i]})) return false;
  }
  return true;
}

}  // namespace

std::vector<std::byte> to_bytes(const MotionsOfMeshes& motions) {
  std::vector<std::byte> bytes;
  for (const std::vector<MeshMotion>& parts : motions) {
    add_count(bytes, parts.size());
    for (const MeshMotion& motion : parts) {
      add_count(bytes, motion.steps.size());
      add(bytes, motion.steps.data(), motion.steps.size());
      add_count(bytes, motion.step_times.size());
      add(bytes, motion.step_times.data(), motion.step_times.size());
    }
  }
  return bytes;
}

std::optional<MotionsOfMeshes> to_motions(std::span<const std::byte> bytes,
                                          std::span<const TimeRange> time_ranges) {
  Taken taken(bytes);
  MotionsOfMeshes motions;
  for (const TimeRange& time_range : time_ranges) {
    std::size_t parts = 0;
    if (!taken.take_count(parts) || parts > bytes.size()) return std::nullopt;
    motions.emplace_back(parts);
    for (MeshMotion& motion : motions.back()) {
      motion.time_range = time_range;
      if (!take_motion(taken, motion)) return std::nullopt;
    }
  }
  return taken.is_at_end() ? std::optional(std::move(motions)) : std::nullopt;
}

}  // namespace stbvh::plugin
