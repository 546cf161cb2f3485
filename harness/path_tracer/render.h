/// Pictures of scenes, in layers, through any structure under test.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "harness/images/layered_image.h"
#include "harness/path_tracer/render_settings.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

struct Rendering {
  /// R, G, B: linear radiance; variance.R/G/B: of their means; of what the camera's rays hit, means over the
  /// samples: albedo.R/G/B and normal.X/Y/Z (0 for misses), depth.Z, time.T and motion.X/Y over those that
  /// hit (0 where none does; motion: pixels from the shutter's opening to its closing); mesh.id,
  /// primitive.id and face.id of the first sample (kInvalidId: nothing). nodes.N and triangles.N: what the
  /// camera's rays met in the tree, means, only from structures that count. Tiles that are not finished are
  /// black. Of a strip, the rows that it has, with the whole picture as display window.
  LayeredImage image;
  std::uint64_t rays = 0;        ///< of all kinds
  std::uint64_t not_finite = 0;  ///< samples left out because their radiance was NaN or infinite: an error
  double seconds = 0;
  bool is_complete = true;  ///< false: it was stopped
};

/// Throws std::invalid_argument for a size or a number of samples that no picture has.
void check_picture(const RenderSettings& settings);

/// Told the fraction done, 0 to 1, never decreasing, one call at a time but from any thread.
using RenderProgress = std::function<void(double fraction)>;

/// Renders `scene` through its camera and `structure`, built over it (path_tracer.h). Once `stop` is true no
/// more tiles are begun. The image depends on scene, settings and the structure's answers only, not on the
/// number of threads. Throws std::invalid_argument for settings, a camera, a mesh or a light that cannot be.
Rendering render(const Scene& scene, const StructureUnderTest& structure, const RenderSettings& settings,
                 const RenderProgress& progress = {}, const std::atomic<bool>* stop = nullptr);

/// The most bytes that the image of a rendering takes.
std::size_t rendering_bytes(const RenderSettings& settings);

}  // namespace stbvh::harness
