#include "tests/failing_allocations.h"

#include <dlfcn.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

namespace stbvh::test {
namespace {

constexpr long kNever = std::numeric_limits<long>::max();

std::atomic<long> first_to_fail{kNever}, last_to_fail{kNever};
std::atomic<long> calls{0};
std::atomic<const void*> spared_library{nullptr};

const void* library_of(const void* code) {
  Dl_info info;
  return dladdr(code, &info) != 0 ? info.dli_fbase : nullptr;
}

bool fails(const void* caller) {
  const void* const spared = spared_library;
  if (spared != nullptr && library_of(caller) == spared) return false;
  const long number = calls.fetch_add(1, std::memory_order_relaxed);
  return number >= first_to_fail.load(std::memory_order_relaxed) &&
         number <= last_to_fail.load(std::memory_order_relaxed);
}

void* allocate(const void* caller, std::size_t bytes) noexcept {
  return fails(caller) ? nullptr : std::malloc(bytes == 0 ? 1 : bytes);
}

void* allocate(const void* caller, std::size_t bytes, std::align_val_t alignment) noexcept {
  const auto align = static_cast<std::size_t>(alignment);
  return fails(caller) ? nullptr : std::aligned_alloc(align, (bytes + align - 1) / align * align);
}

void* or_throw(void* memory) {
  if (memory != nullptr) return memory;
  if (const std::new_handler handler = std::get_new_handler()) handler();
  throw std::bad_alloc();
}

}  // namespace

FailingAllocations::FailingAllocations(long number, Which which) {
  calls = 0;
  last_to_fail = which == Which::kOne ? number : kNever - 1;
  first_to_fail = number;
}

FailingAllocations::~FailingAllocations() {
  first_to_fail = kNever;
}

bool FailingAllocations::have_failed() const {
  return calls > first_to_fail;
}

SparedLibrary::SparedLibrary(const void* function) {
  spared_library = library_of(function);
}

SparedLibrary::~SparedLibrary() {
  spared_library = nullptr;
}

}  // namespace stbvh::test

using stbvh::test::allocate;
using stbvh::test::or_throw;

void* operator new(std::size_t bytes) {
  return or_throw(allocate(__builtin_return_address(0), bytes));
}
void* operator new[](std::size_t bytes) {
  return or_throw(allocate(__builtin_return_address(0), bytes));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return or_throw(allocate(__builtin_return_address(0), bytes, alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate(__builtin_return_address(0), bytes);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate(__builtin_return_address(0), bytes);
}
void* operator new(std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate(__builtin_return_address(0), bytes, alignment);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
