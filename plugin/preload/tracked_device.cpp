#include "plugin/preload/tracked_device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <new>
#include <string>
#include <string_view>
#include <unordered_map>

#include "plugin/layout_trial.h"
#include "plugin/preload/real_embree.h"
#include "plugin/preload/unique_number.h"

namespace stbvh::preload {
namespace {

/// Of this many devices: an error "out of memory" must not want memory.
constexpr std::size_t kMostPending = 16;

struct PendingError {
  std::uint64_t device = 0;  ///< TrackedDevice::serial()
  RTCError code = RTC_ERROR_NONE;
};

struct ThreadErrors {
  std::array<PendingError, kMostPending> pending;  ///< the latest in front, RTC_ERROR_NONE behind the last
  unsigned reported = 0;
  unsigned muted = 0;
  std::uint64_t message_of = 0;  ///< the device whose latest error is ours
  std::array<char, 128> message{};
};

thread_local ThreadErrors thread_errors;

/// Embree says no device's end, so an entry stays until its address is another device's.
struct Devices {
  std::mutex mutex;
  std::unordered_map<RTCDevice, std::shared_ptr<TrackedDevice>> by_handle;
};

Devices& devices() {
  static auto* const kDevices = new Devices;  // outlives what runs at exit
  return *kDevices;
}

PendingError* find_pending(std::uint64_t device) {
  auto& pending = thread_errors.pending;
  const auto found = std::find_if(pending.begin(), pending.end(), [&](const PendingError& entry) {
    return entry.code != RTC_ERROR_NONE && entry.device == device;
  });
  return found == pending.end() ? nullptr : &*found;
}

void keep_pending(const TrackedDevice& device, RTCError code) {
  if (find_pending(device.serial()) != nullptr) return;
  auto& pending = thread_errors.pending;
  std::move_backward(pending.begin(), pending.end() - 1, pending.end());
  pending[0] = {device.serial(), code};
}

/// Embree's own error of this thread, taken away. It takes memory for a thread's first, and throws without.
RTCError take_native_error(RTCDevice device) {
  try {
    return real().rtcGetDeviceError(device);
  } catch (const std::bad_alloc&) {
    return RTC_ERROR_NONE;
  }
}

/// Whether triangles are hit as our structure hits them: masks and filters count, backs are hit.
bool hits_as_we_do(RTCDevice device) {
  const auto property = [&](RTCDeviceProperty which) { return real().rtcGetDeviceProperty(device, which); };
  return property(RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) != 0 &&
         property(RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED) == 0 &&
         property(RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) != 0 &&
         property(RTC_DEVICE_PROPERTY_USER_GEOMETRY_SUPPORTED) != 0;
}

StaysNative why_native(RTCDevice device) {
  if (!hits_as_we_do(device)) return StaysNative::kDevice;
#if RTC_VERSION_MAJOR >= 4
  static const plugin::EmbreeLayout kLayout = plugin::try_layout<real>(device);
  if (!kLayout.options_behind_arguments || !kLayout.hits) return StaysNative::kLayout;
#endif
  return StaysNative::kNone;
}

}  // namespace

TrackedDevice::TrackedDevice(RTCDevice handle, int thread_limit)
    : serial_(unique_number()),
      handle_(handle),
      thread_limit_(thread_limit),
      why_native_(preload::why_native(handle)) {}

void TrackedDevice::set_error_function(RTCErrorFunction function, void* user_ptr) {
  const std::lock_guard lock(mutex_);
  error_function_ = function;
  error_user_ptr_ = user_ptr;
}

void TrackedDevice::set_memory_monitor(RTCMemoryMonitorFunction function, void* user_ptr) {
  const std::lock_guard lock(mutex_);
  memory_monitor_ = function;
  memory_user_ptr_ = user_ptr;
}

void TrackedDevice::tell(RTCError code, const char* message) {
  std::unique_lock lock(mutex_);
  const RTCErrorFunction function = error_function_;
  void* const user_ptr = error_user_ptr_;
  lock.unlock();
  if (function != nullptr) function(user_ptr, code, message);
}

void TrackedDevice::raise(RTCError code, const char* message) {
  tell(code, message);
  const RTCError earlier = take_native_error(handle_);
  keep_pending(*this, earlier != RTC_ERROR_NONE ? earlier : code);
  thread_errors.message_of = serial_;
  std::snprintf(thread_errors.message.data(), thread_errors.message.size(), "%s", message);
}

bool TrackedDevice::report_memory(ssize_t bytes) {
  std::unique_lock lock(mutex_);
  const RTCMemoryMonitorFunction monitor = memory_monitor_;
  void* const user_ptr = memory_user_ptr_;
  lock.unlock();
  // As Embree: before memory is taken, after it was given back; what is given back cannot be refused.
  return monitor == nullptr || bytes == 0 || monitor(user_ptr, bytes, bytes < 0) || bytes < 0;
}

void TrackedDevice::on_error(void* device, RTCError code, const char* message) {
  ++thread_errors.reported;
  if (thread_errors.muted != 0) return;
  TrackedDevice& self = *static_cast<TrackedDevice*>(device);
  if (thread_errors.message_of == self.serial()) thread_errors.message_of = 0;
  self.tell(code, message);
}

std::shared_ptr<TrackedDevice> find_device(RTCDevice handle) {
  const std::lock_guard lock(devices().mutex);
  const auto found = devices().by_handle.find(handle);
  return found == devices().by_handle.end() ? nullptr : found->second;
}

int thread_limit_of(const char* config) {
  std::string text(config == nullptr ? "" : config);
  std::erase_if(text, [](unsigned char c) { return std::isspace(c) != 0; });
  constexpr std::string_view kKey = "threads=";
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    if (text.compare(start, kKey.size(), kKey) == 0) {
      int threads = 0;
      std::from_chars(text.data() + start + kKey.size(), text.data() + end, threads);
      return std::max(threads, 0);
    }
    start = end + 1;
  }
  return 0;
}

void track_device(RTCDevice handle, const char* config) {
  auto device = std::make_shared<TrackedDevice>(handle, thread_limit_of(config));
  {
    const std::lock_guard lock(devices().mutex);
    devices().by_handle[handle] = device;
  }
  real().rtcSetDeviceErrorFunction(handle, TrackedDevice::on_error, device.get());
}

RTCError take_pending_error(RTCDevice handle) {
  auto& pending = thread_errors.pending;
  if (pending[0].code == RTC_ERROR_NONE) return RTC_ERROR_NONE;
  const auto device = find_device(handle);
  PendingError* const found = device == nullptr ? nullptr : find_pending(device->serial());
  if (found == nullptr) return RTC_ERROR_NONE;
  const RTCError code = found->code;
  std::move(found + 1, pending.data() + pending.size(), found);
  pending.back() = {};
  return code;
}

const char* own_error_message(RTCDevice handle) {
  const auto device = thread_errors.message_of == 0 ? nullptr : find_device(handle);
  const bool is_own = device != nullptr && device->serial() == thread_errors.message_of;
  return is_own ? thread_errors.message.data() : nullptr;
}

ErrorWatch::ErrorWatch() : seen_(thread_errors.reported) {}

bool ErrorWatch::failed() const {
  return thread_errors.reported != seen_;
}

Muted::Muted(const TrackedDevice& device) : device_(device), earlier_(take_native_error(device.handle())) {
  ++thread_errors.muted;
}

Muted::~Muted() {
  --thread_errors.muted;
  take_native_error(device_.handle());
  if (earlier_ != RTC_ERROR_NONE) keep_pending(device_, earlier_);
}

}  // namespace stbvh::preload
