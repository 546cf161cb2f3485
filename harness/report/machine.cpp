#include "harness/report/machine.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <fstream>
#include <new>

#include "stbvh/isa.h"
#include "stbvh/stbvh_embree.h"
#include "stbvh_commit.h"

namespace stbvh::harness {
namespace {

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

unsigned usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof(set), &set);
  return static_cast<unsigned>(CPU_COUNT(&set));
}

std::string embree_version() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (device == nullptr) {
    if (rtcGetDeviceError(nullptr) == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    return "unavailable";
  }
  const auto number = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property); };
  const std::string version =
      fmt::format("{}.{}.{}", number(RTC_DEVICE_PROPERTY_VERSION_MAJOR),
                  number(RTC_DEVICE_PROPERTY_VERSION_MINOR), number(RTC_DEVICE_PROPERTY_VERSION_PATCH));
  rtcReleaseDevice(device);
  return version;
}

}  // namespace

Machine this_machine() {
  const double bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return {.cpu = cpu_model(),
          .cores = usable_cores(),
          .memory_gb = bytes / 1e9,
          .instruction_set = std::string(isa_name(default_isa())),
          .embree = embree_version()};
}

std::string built_commit() {
  return STBVH_COMMIT;
}

std::string version_text(std::string_view program) {
  return fmt::format("{} (STBVH for Embree) {} ({})", program, STBVH_PROJECT_VERSION, built_commit());
}

}  // namespace stbvh::harness
