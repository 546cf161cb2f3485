/// Errors and memory of a device, as Embree reports them.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "plugin/embree_api.h"
#include "plugin/preload/stays_native.h"

namespace stbvh::preload {

/// What the application set on a device. Embree's own error function is always ours, which passes errors on.
class TrackedDevice {
 public:
  TrackedDevice(RTCDevice handle, int thread_limit);

  RTCDevice handle() const { return handle_; }
  /// No other device has it, though a handle may come again when a device is gone.
  std::uint64_t serial() const { return serial_; }
  /// Threads that may build; 0: all.
  int thread_limit() const { return thread_limit_; }

  /// Why all meshes of this Embree stay with it; kNone: they do not.
  StaysNative why_native() const { return why_native_; }

  void set_error_function(RTCErrorFunction function, void* user_ptr);
  void set_memory_monitor(RTCMemoryMonitorFunction function, void* user_ptr);

  /// Reports an error of ours as Embree does its own: to the error function, and to rtcGetDeviceError of this
  /// thread, which keeps the first.
  void raise(RTCError code, const char* message);
  void raise_out_of_memory() { raise(RTC_ERROR_OUT_OF_MEMORY, "out of memory"); }

  /// Asks the memory monitor for `bytes` (negative: gives them back). False if it refuses; the application
  /// does not count them then.
  bool report_memory(ssize_t bytes);

  /// What Embree calls: `device` is the TrackedDevice.
  static void on_error(void* device, RTCError code, const char* message);

 private:
  void tell(RTCError code, const char* message);

  const std::uint64_t serial_;
  const RTCDevice handle_;
  const int thread_limit_;
  const StaysNative why_native_;
  std::mutex mutex_;
  RTCErrorFunction error_function_ = nullptr;
  void* error_user_ptr_ = nullptr;
  RTCMemoryMonitorFunction memory_monitor_ = nullptr;
  void* memory_user_ptr_ = nullptr;
};

/// The device of a handle that rtcNewDevice returned, or null.
std::shared_ptr<TrackedDevice> find_device(RTCDevice handle);

/// After rtcNewDevice with `config`, which may be null.
void track_device(RTCDevice handle, const char* config);

/// The value of `threads` in a device's configuration ("threads=4,isa=avx2"); 0 without one.
int thread_limit_of(const char* config);

/// An error of ours that this thread has not asked for, taken away; RTC_ERROR_NONE without one.
RTCError take_pending_error(RTCDevice handle);

/// What the latest error of this thread and device says, if it is one of ours; else null.
const char* own_error_message(RTCDevice handle);

/// Whether Embree reported an error to this thread since this was made.
class ErrorWatch {
 public:
  ErrorWatch();
  bool failed() const;

 private:
  unsigned seen_;
};

/// While it lives, what Embree reports to this thread is neither told to the application nor left behind.
class Muted {
 public:
  explicit Muted(const TrackedDevice& device);
  ~Muted();
  Muted(const Muted&) = delete;
  Muted& operator=(const Muted&) = delete;

 private:
  const TrackedDevice& device_;
  RTCError earlier_;
};

}  // namespace stbvh::preload
