/// What Embree makes of packets on this processor.
#pragma once

#include <embree3/rtcore.h>

namespace stbvh::test {

/// Whether Embree traces packets of N as such. Where it does not it cuts them up as it does streams, and
/// takes only tnear > tfar for switched off: `valid` is not looked at.
template <unsigned N>
bool is_native_width(RTCDevice device) {
  constexpr RTCDeviceProperty kProperty = N == 4   ? RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED
                                          : N == 8 ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                   : RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED;
  return rtcGetDeviceProperty(device, kProperty) != 0;
}

}  // namespace stbvh::test
