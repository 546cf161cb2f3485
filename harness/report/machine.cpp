#include "harness/report/machine.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <new>

#include "harness/files/input_file.h"
#include "harness/files/text.h"
#include "stbvh/isa.h"
#include "stbvh/stbvh_embree.h"
#include "stbvh_commit.h"

namespace stbvh::harness {
namespace {

/// The first processor's name, with family and model: virtual machines often leave the generation out of it.
std::string cpu_model() {
  const std::string text = read_proc_file("/proc/cpuinfo");
  std::string_view name = "unknown", family, model, rest = text;
  for (auto line = take_line(rest); !line.empty(); line = take_line(rest)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos || colon + 2 > line.size()) continue;
    const std::string_view key = line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1);
    const std::string_view value = line.substr(colon + 2);
    if (key == "model name") name = value;
    if (key == "cpu family") family = value;
    if (key == "model") model = value;
  }
  return family.empty() || model.empty() ? std::string(name)
                                         : fmt::format("{} (family {}, model {})", name, family, model);
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
