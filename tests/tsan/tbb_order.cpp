// What the thread sanitizer cannot see of TBB, told to it. libtbb is not built with the sanitizer: that a
// task begins after it was spawned, and that a wait ends after all that it waits for, looks like no order at
// all, and each access of a task like a race. A suppression would hide the races of all that runs in tasks.
// So programs under the thread sanitizer bring their own version of the functions through which tasks are
// handed on: they call libtbb's, and say what comes first. Embree's tasks go the same way.
#include <dlfcn.h>
#include <sanitizer/tsan_interface.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace tbb::detail {
namespace {

/// libtbb's own function.
template <class... Arguments>
auto in_libtbb(const char* mangled_name) {
  return reinterpret_cast<void (*)(Arguments...)>(dlsym(RTLD_NEXT, mangled_name));
}

/// Stands for a task that is spawned: what came before that comes before its execution.
class OrderedTask final : public d1::task {
 public:
  explicit OrderedTask(d1::task& spawned) : spawned_(spawned) { __tsan_release(this); }
  d1::task* execute(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* const next = spawned_.execute(data);  // if it throws, cancel() follows
    delete this;
    return next;
  }
  d1::task* cancel(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* const next = spawned_.cancel(data);
    delete this;
    return next;
  }

 private:
  d1::task& spawned_;
};

/// Stands for what an arena executes, perhaps on another of its threads.
class OrderedDelegate final : public d1::delegate_base {
 public:
  explicit OrderedDelegate(d1::delegate_base& delegate) : delegate_(delegate) { __tsan_release(&key_); }
  ~OrderedDelegate() { __tsan_acquire(&key_); }
  bool operator()() const override {
    __tsan_acquire(&key_);
    const bool result = delegate_();
    __tsan_release(&key_);
    return result;
  }

 private:
  d1::delegate_base& delegate_;
  mutable char key_ = 0;
};

/// When a wait ends, also by an exception, all that it waited for has been done: the headers counted it down
/// to 0, where the sanitizer saw them, in the second word.
class OrderedWait {
 public:
  explicit OrderedWait(d1::wait_context& context) : count_(reinterpret_cast<std::uint64_t*>(&context) + 1) {}
  ~OrderedWait() { __tsan_acquire(count_); }
  OrderedWait(const OrderedWait&) = delete;
  OrderedWait& operator=(const OrderedWait&) = delete;

 private:
  std::uint64_t* count_;
};

/// libtbb uses memory again without telling the sanitizer.
void* allocated(std::size_t bytes) {
  constexpr std::size_t kAlignment = 128;  // of TBB's cache_aligned_allocate
  return std::aligned_alloc(kAlignment, (bytes + kAlignment - 1) / kAlignment * kAlignment);
}

struct NoPool : d1::small_object_pool {
} no_pool;

}  // namespace

namespace r1 {

void spawn(d1::task& task, d1::task_group_context& context) {
  static const auto of_tbb = in_libtbb<d1::task&, d1::task_group_context&>(
      "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextE");
  of_tbb(*new OrderedTask(task), context);
}

void spawn(d1::task& task, d1::task_group_context& context, d1::slot_id slot) {
  static const auto of_tbb = in_libtbb<d1::task&, d1::task_group_context&, d1::slot_id>(
      "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextEt");
  of_tbb(*new OrderedTask(task), context, slot);
}

void execute_and_wait(d1::task& task, d1::task_group_context& context, d1::wait_context& done,
                      d1::task_group_context& waiting) {
  static const auto of_tbb =
      in_libtbb<d1::task&, d1::task_group_context&, d1::wait_context&, d1::task_group_context&>(
          "_ZN3tbb6detail2r116execute_and_waitERNS0_2d14taskERNS2_18task_group_contextERNS2_"
          "12wait_contextES6_");
  const OrderedWait wait(done);
  of_tbb(task, context, done, waiting);
}

void wait(d1::wait_context& done, d1::task_group_context& context) {
  static const auto of_tbb = in_libtbb<d1::wait_context&, d1::task_group_context&>(
      "_ZN3tbb6detail2r14waitERNS0_2d112wait_contextERNS2_18task_group_contextE");
  const OrderedWait wait(done);
  of_tbb(done, context);
}

void execute(d1::task_arena_base& arena, d1::delegate_base& delegate) {
  static const auto of_tbb = in_libtbb<d1::task_arena_base&, d1::delegate_base&>(
      "_ZN3tbb6detail2r17executeERNS0_2d115task_arena_baseERNS2_13delegate_baseE");
  OrderedDelegate ordered(delegate);
  of_tbb(arena, ordered);
}

void* allocate(d1::small_object_pool*& pool, std::size_t bytes) {
  pool = &no_pool;
  return allocated(bytes);
}
void* allocate(d1::small_object_pool*& pool, std::size_t bytes, const d1::execution_data&) {
  return allocate(pool, bytes);
}
void deallocate(d1::small_object_pool&, void* memory, std::size_t) {
  std::free(memory);
}
void deallocate(d1::small_object_pool&, void* memory, std::size_t, const d1::execution_data&) {
  std::free(memory);
}
void* allocate_memory(std::size_t bytes) {
  return allocated(bytes);
}
void deallocate_memory(void* memory) {
  std::free(memory);
}
void* cache_aligned_allocate(std::size_t bytes) {
  return allocated(bytes);
}
void cache_aligned_deallocate(void* memory) {
  std::free(memory);
}

}  // namespace r1
}  // namespace tbb::detail
