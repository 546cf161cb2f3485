/// Structs of the C interface: an application passes the struct of its own header, whose size it has written
/// into the first member. Later headers only append members.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>

#include "plugin/mesh_description.h"

namespace stbvh::plugin {

/// The byteSize at `given`, of which nothing else is read; `name` is for the message. Throws ApiError where
/// no header has had a struct of that size: below `first_size`, larger than ours, or not a multiple of its
/// alignment.
template <typename Struct>
std::size_t checked_byte_size(const Struct* given, std::size_t first_size, const char* name) {
  static_assert(offsetof(Struct, byteSize) == 0);
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof(size));
  if (size >= first_size && size <= sizeof(Struct) && size % alignof(Struct) == 0) return size;
  const std::string sizes =
      std::string(name) + "->byteSize is " + std::to_string(size) + ", this library's " +
      std::to_string(sizeof(Struct)) +
      (size > sizeof(Struct) ? ": it was not initialised, or the header is newer than the library"
                             : ": it was not initialised");
  throw ApiError(RTC_ERROR_INVALID_ARGUMENT, sizes);
}

/// `given` in our size: members that its header does not have are those of `defaults`.
template <typename Struct>
Struct read_versioned(const Struct* given, Struct defaults, std::size_t first_size, const char* name) {
  std::memcpy(&defaults, given, checked_byte_size(given, first_size, name));
  defaults.byteSize = sizeof(Struct);
  return defaults;
}

/// Writes the members that the header of `target` has, and no byte behind them; its byteSize stays.
template <typename Struct>
void write_versioned(Struct* target, Struct values, std::size_t first_size, const char* name) {
  values.byteSize = checked_byte_size(target, first_size, name);
  std::memcpy(target, &values, values.byteSize);
}

}  // namespace stbvh::plugin
