/// Many frames of an animation as one scene, and each of them as one of its own.
#pragma once

#include <cstddef>

#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// An animation of `frames` frames over the times [0, 1]: the motion of `shutter`, forwards and backwards in
/// turns, one frame each. Throws SceneFileError where a mesh that moves is not there all the time, has steps
/// at times of its own, or would have more than kMaxSteps steps.
Scene played(const Scene& shutter, std::size_t frames);

/// Frame number `frame` of that, over the times [0, 1].
Scene frame_of(const Scene& shutter, std::size_t frame);

/// The same motion in meshes of at most kMaxSceneSteps steps, each over a part of the time, for structures of
/// Embree.
Scene in_pieces(Scene scene);

}  // namespace stbvh::harness
