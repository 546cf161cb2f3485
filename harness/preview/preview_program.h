/// The program stbvh-preview.
#pragma once

namespace stbvh::harness {

/// Opens the window and runs until it is closed, or the script or screenshot is done. Prints one line on
/// stderr for what cannot be done. Returns the exit code: 0 done; 2 the user asked for what cannot be done,
/// or there is no display with OpenGL 3.3; 1 it went wrong.
int run_preview(int argc, const char* const* argv);

}  // namespace stbvh::harness
