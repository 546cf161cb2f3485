/// Lines in space, drawn into a picture.
#pragma once

#include <array>
#include <cstdint>

#include "harness/images/image.h"
#include "harness/path_tracer/lens_camera.h"

namespace stbvh::harness {

class LineDrawing {
 public:
  /// Both must outlive this.
  LineDrawing(Image& image, const Camera& camera);

  /// What lies in front of the camera and inside of the picture of the line from `a` to `b`, one pixel wide.
  void line(Vec3 a, Vec3 b, std::array<std::uint8_t, 3> color);

 private:
  Image& image_;
  LensCamera lens_;
  Vec3 position_, axis_;
  double nearest_;  ///< depth at which lines are cut off
};

}  // namespace stbvh::harness
