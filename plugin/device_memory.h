/// Memory that the memory monitor of an Embree device is told of.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <vector>

#include "plugin/embree_api.h"

namespace stbvh::plugin {

/// `bytes` of memory aligned to 64, counted by the device's memory monitor.
/// Throws std::bad_alloc if there is none or the monitor refuses; the device's error is set then.
void* allocate_on_device(RTCDevice device, std::size_t bytes);

/// Gives back what allocate_on_device returned; null is ignored.
void release_on_device(void* data);

/// Announces temporary memory to the device's memory monitor.
///
/// Embree reports only what it allocates itself, so this holds buffers that nobody touches, as many bytes as
/// the temporary memory takes: address space, no resident memory. Small amounts are gathered into blocks of
/// kBlockBytes.
class TemporaryMemory {
 public:
  static constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

  explicit TemporaryMemory(RTCDevice device) : device_(device) {}
  ~TemporaryMemory();
  TemporaryMemory(const TemporaryMemory&) = delete;
  TemporaryMemory& operator=(const TemporaryMemory&) = delete;

  /// Adds `bytes` (negative: takes away). False if the monitor refuses or there is no memory, also on every
  /// later call. Any thread may call.
  bool report(std::ptrdiff_t bytes);

  /// Whether report() has returned false.
  bool refused() const { return refused_.load(std::memory_order_relaxed); }

 private:
  struct Block {
    RTCBuffer buffer;
    std::size_t bytes;
  };

  RTCBuffer new_block(std::size_t bytes);
  void grow();
  void shrink();

  RTCDevice device_;
  std::atomic<std::ptrdiff_t> in_use_{0};
  std::atomic<std::ptrdiff_t> announced_{0};
  std::atomic<bool> refused_{false};
  std::mutex mutex_;
  std::vector<Block> blocks_;
};

}  // namespace stbvh::plugin
