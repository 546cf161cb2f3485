/// Rays out of the fuzzer's bytes.
#pragma once

#include <span>

#include "byte_reader.h"
#include "stbvh/structure.h"

namespace stbvh::fuzz {

/// Any bit patterns, or a ray aimed at a point of a triangle of `meshes`, which must be readable (their
/// triangles need not be valid), at a time that is any, or at or beside a boundary of two steps.
Ray take_ray(ByteReader& in, std::span<const MeshView> meshes);

}  // namespace stbvh::fuzz
