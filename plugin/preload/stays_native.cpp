#include "plugin/preload/stays_native.h"

namespace stbvh::preload {

const char* describe(StaysNative reason) {
  switch (reason) {
    case StaysNative::kNone:
      return "taken over";
    case StaysNative::kOneStep:
      return "one time step";
    case StaysNative::kUncommitted:
      return "changed and not committed";
    case StaysNative::kBuffers:
      return "buffers missing, not alike or not readable";
    case StaysNative::kTimeRange:
      return "time range empty, next to empty or not finite";
    case StaysNative::kTooLarge:
      return "too large";
    case StaysNative::kLayout:
      return "Embree that lays out queries otherwise";
    case StaysNative::kNoMemory:
      return "no memory to follow it";
    case StaysNative::kDevice:
      return "Embree without ray masks or filters, or with backface culling";
  }
  return "";
}

}  // namespace stbvh::preload
