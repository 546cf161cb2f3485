/// A camera for a scene that brings none.
#pragma once

#include "harness/scenes/scene.h"

namespace stbvh::harness::gltf {

/// Looks from the front right and a little above (glTF's front is +z), as near as it can with every vertex of
/// every step in a picture of kPictureAspect; nearer where that would be too far away for a camera. The
/// default camera for a scene without extent.
Camera framing_camera(const Scene& scene);

}  // namespace stbvh::harness::gltf
