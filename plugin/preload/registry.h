/// What this library knows of the application's handles.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace stbvh::preload {

/// Objects by handle, with the application's references to the handle: an object lives as long as the
/// application has references, or somebody else (a scene, an instance) holds the object.
///
/// As Embree frees a handle with its last reference, calls must come before Embree's own release: the address
/// may be another object's as soon as that returns.
template <typename Handle, typename Object>
class Registry {
 public:
  /// A new handle, with one reference of the application.
  void add(Handle handle, std::shared_ptr<Object> object) {
    Entry entry{object.get(), object, object, 1};
    Shard& shard = shard_of(handle);
    const std::lock_guard lock(shard.mutex);
    std::swap(shard.entries[handle], entry);
  }

  /// Null for a handle that is not known.
  std::shared_ptr<Object> find(Handle handle) {
    Shard& shard = shard_of(handle);
    const std::lock_guard lock(shard.mutex);
    const auto found = shard.entries.find(handle);
    return found == shard.entries.end() ? nullptr : found->second.object.lock();
  }

  /// One more reference of the application.
  void retain(Handle handle) {
    Shard& shard = shard_of(handle);
    const std::lock_guard lock(shard.mutex);
    const auto found = shard.entries.find(handle);
    if (found == shard.entries.end()) return;
    if (found->second.references++ == 0) found->second.owned = found->second.object.lock();
  }

  /// One less.
  void release(Handle handle) {
    std::shared_ptr<Object> last;  // dies after the lock: it may hold other handles
    Shard& shard = shard_of(handle);
    const std::lock_guard lock(shard.mutex);
    const auto found = shard.entries.find(handle);
    if (found == shard.entries.end() || found->second.references == 0) return;
    if (--found->second.references == 0) last = std::move(found->second.owned);
  }

  /// For the destructor of an object.
  void forget(Handle handle, const Object* object) {
    Shard& shard = shard_of(handle);
    const std::lock_guard lock(shard.mutex);
    const auto found = shard.entries.find(handle);
    if (found != shard.entries.end() && found->second.address == object) shard.entries.erase(found);
  }

 private:
  struct Entry {
    const Object* address = nullptr;
    std::weak_ptr<Object> object;
    std::shared_ptr<Object> owned;  ///< while the application has references
    std::size_t references = 0;
  };
  struct Shard {
    std::mutex mutex;
    std::unordered_map<Handle, Entry> entries;
  };
  static constexpr std::size_t kShards = 64;

  Shard& shard_of(Handle handle) {
    const auto bits = reinterpret_cast<std::uintptr_t>(handle) * std::uintptr_t{0x9E3779B97F4A7C15};
    return shards_[bits >> 58];
  }

  std::array<Shard, kShards> shards_;
};

}  // namespace stbvh::preload
