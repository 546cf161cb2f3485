/// What an OpenEXR file says of itself, before it is believed.
#pragma once

#include <ImfHeader.h>

#include <cstddef>
#include <string>

#include "harness/images/layered_image.h"

namespace stbvh::harness {

inline constexpr std::size_t kMaxExrSide = 65536;  ///< pixels

PixelWindow to_window(const Imath::Box2i& box);

/// The header of a file of one part that has each pixel once, with a size and with attributes that the file
/// can hold: whatever OpenEXR allocates for it, it has been held against the size of the file. Throws
/// Iex::InputExc, or what OpenEXR throws. Gives attributes in `file` that only OpenEXR itself could hold
/// against it another type, so that OpenEXR passes over them.
Imf::Header read_exr_header(std::string& file);

}  // namespace stbvh::harness
