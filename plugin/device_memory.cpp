#include "plugin/device_memory.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>

namespace stbvh::plugin {
namespace {

constexpr std::size_t kAlignment = 64;
/// In front of the memory handed out lies the handle of its buffer.
constexpr std::size_t kOverhead = kAlignment + sizeof(RTCBuffer);

}  // namespace

void* allocate_on_device(RTCDevice device, std::size_t bytes) {
  if (bytes > std::numeric_limits<std::size_t>::max() - kOverhead) throw std::bad_alloc();
  const RTCBuffer buffer = rtcNewBuffer(device, bytes + kOverhead);
  if (buffer == nullptr) throw std::bad_alloc();
  // rtcNewBuffer aligns to 16 only.
  auto* const start = static_cast<char*>(rtcGetBufferData(buffer));
  const auto first_free = reinterpret_cast<std::uintptr_t>(start) + sizeof(RTCBuffer);
  const std::size_t padding = (kAlignment - first_free % kAlignment) % kAlignment;
  char* const data = start + sizeof(RTCBuffer) + padding;
  std::memcpy(data - sizeof(RTCBuffer), &buffer, sizeof(RTCBuffer));
  return data;
}

void release_on_device(void* data) {
  if (data == nullptr) return;
  RTCBuffer buffer;
  std::memcpy(&buffer, static_cast<char*>(data) - sizeof(RTCBuffer), sizeof(RTCBuffer));
  rtcReleaseBuffer(buffer);
}

TemporaryMemory::~TemporaryMemory() {
  for (const Block& block : blocks_) rtcReleaseBuffer(block.buffer);
}

bool TemporaryMemory::report(std::ptrdiff_t bytes) {
  const std::ptrdiff_t in_use = in_use_.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  const std::ptrdiff_t announced = announced_.load(std::memory_order_relaxed);
  if (in_use > announced) {
    grow();
  } else if (bytes < 0 && announced - in_use > 2 * static_cast<std::ptrdiff_t>(kBlockBytes)) {
    shrink();
  }
  return !refused();
}

/// Null without memory, also for its entry among the blocks. Does not throw: memory is given back in
/// destructors.
RTCBuffer TemporaryMemory::new_block(std::size_t bytes) {
  try {
    blocks_.reserve(blocks_.size() + 1);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
  return rtcNewBuffer(device_, bytes);
}

void TemporaryMemory::grow() {
  const std::lock_guard lock(mutex_);
  const std::ptrdiff_t announced = announced_.load(std::memory_order_relaxed);
  const std::ptrdiff_t missing = in_use_.load(std::memory_order_relaxed) - announced;
  if (missing <= 0 || refused()) return;
  // An eighth of what there is: a large build needs few blocks, and announces at most an eighth too much.
  const auto bytes =
      std::max({kBlockBytes, static_cast<std::size_t>(missing), static_cast<std::size_t>(announced) / 8});
  const RTCBuffer buffer = new_block(bytes);
  if (buffer == nullptr) {
    refused_.store(true, std::memory_order_relaxed);
    return;
  }
  blocks_.push_back({buffer, bytes});  // there is room
  announced_.store(announced + static_cast<std::ptrdiff_t>(bytes), std::memory_order_relaxed);
}

void TemporaryMemory::shrink() {
  const std::lock_guard lock(mutex_);
  std::ptrdiff_t announced = announced_.load(std::memory_order_relaxed);
  const std::ptrdiff_t in_use = in_use_.load(std::memory_order_relaxed);
  while (!blocks_.empty()) {
    const auto bytes = static_cast<std::ptrdiff_t>(blocks_.back().bytes);
    // One block of slack, so that use going up and down around a border does not allocate each time.
    if (announced - bytes < in_use + static_cast<std::ptrdiff_t>(kBlockBytes)) break;
    rtcReleaseBuffer(blocks_.back().buffer);
    blocks_.pop_back();
    announced -= bytes;
  }
  announced_.store(announced, std::memory_order_relaxed);
}

}  // namespace stbvh::plugin
