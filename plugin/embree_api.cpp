#include "plugin/embree_api.h"

#include "plugin/layout_trial.h"
#include "plugin/linked_embree.h"

#if RTC_VERSION_MAJOR >= 4

namespace stbvh::plugin {
namespace {

EmbreeLayout try_linked_embree() {
  const auto release = [](RTCDevice device) { rtcReleaseDevice(device); };
  const std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(release)> device(
      rtcNewDevice("threads=1"));
  if (!device) throw std::bad_alloc();
  return try_layout<linked_embree>(device.get());
}

}  // namespace

EmbreeLayout embree_layout() {
  static const EmbreeLayout kLayout = try_linked_embree();
  return kLayout;
}

}  // namespace stbvh::plugin

#endif
