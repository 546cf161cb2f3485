#include "plugin/embree_api.h"

#include "plugin/linked_embree.h"
#include "plugin/options_trial.h"

#if RTC_VERSION_MAJOR >= 4

namespace stbvh::plugin {
namespace {

bool try_linked_embree() {
  const auto release = [](RTCDevice device) { rtcReleaseDevice(device); };
  const std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(release)> device(
      rtcNewDevice("threads=1"));
  if (!device) throw std::bad_alloc();
  return finds_options_behind_arguments<linked_embree>(device.get());
}

}  // namespace

bool keeps_options_behind_arguments() {
  static const bool keeps = try_linked_embree();
  return keeps;
}

}  // namespace stbvh::plugin

#endif
