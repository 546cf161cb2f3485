/// Scenes without motion, made of scenes with it.
#pragma once

#include "harness/scenes/scene.h"

namespace stbvh::harness {

/// `scene` as it is at `time`, at rest: each mesh that is there then, with one step.
Scene frozen(const Scene& scene, float time);

}  // namespace stbvh::harness
