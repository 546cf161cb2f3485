/// The rays of each kind, deterministic by seed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "harness/rays/ray_set.h"
#include "harness/scenes/scene.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {

/// All kinds, in the order in which tables print them.
std::span<const RayKind> ray_kinds();

/// The kind of that name.
std::optional<RayKind> find_ray_kind(std::string_view name);

/// Whether Embree can be asked with `ray`: finite and at most kMaxCoordinate, a direction, a time in [0, 1],
/// 0 <= tnear <= tfar.
/// Debian's Embree aborts the process on others.
bool is_traceable(const Ray& ray);

/// Makes `count` rays of `kind` through `scene`, all traceable; times are random in [0, 1].
///
/// primary: through the camera, one jittered ray for each pixel, row by row.
/// bounce:  cosine-distributed from points that random camera rays hit, shuffled.
/// shadow:  from such points, half to one light above the scene, half to random points of a sky; shuffled.
/// uniform: from random points of the scene's bounds, half in random directions, half to random points on
/// geometry.
/// bounce-occluded, uniform-occluded: the rays of bounce and uniform, asked whether anything is in their way.
///
/// Hit points are `reference`'s, never those of a structure under test, and lie off the surface by some tens
/// of its roundings. Where the camera sees nothing, rays to random points on geometry find them; where these
/// hit nothing either, bounce and shadow have fewer rays, or none. The rays do not depend on the number of
/// threads.
RaySet make_rays(RayKind kind, const Scene& scene, const StructureUnderTest& reference, std::size_t count,
                 std::uint64_t seed);

}  // namespace stbvh::harness
