#include "plugin/preload/published_pool.h"

#include <cstdint>
#include <mutex>
#include <new>

namespace stbvh::preload {
namespace {

constexpr std::size_t kCells = std::size_t{1} << 17;

union alignas(64) Cell {
  Cell* next_free;
  std::byte bytes[kPublishedCellBytes];
};

Cell cells[kCells];  // addresses: memory is taken by those that are used
std::mutex mutex;
Cell* first_free = nullptr;
std::size_t used_once = 0;

}  // namespace

void* allocate_published() {
  const std::lock_guard lock(mutex);
  if (first_free != nullptr) {
    Cell* const cell = first_free;
    first_free = cell->next_free;
    return cell;
  }
  if (used_once == kCells) throw std::bad_alloc();
  return &cells[used_once++];
}

void release_published(void* cell) noexcept {
  const std::lock_guard lock(mutex);
  Cell* const freed = static_cast<Cell*>(cell);
  freed->next_free = first_free;
  first_free = freed;
}

bool is_in_published_pool(const void* address) {
  return reinterpret_cast<std::uintptr_t>(address) - reinterpret_cast<std::uintptr_t>(cells) < sizeof(cells);
}

}  // namespace stbvh::preload
