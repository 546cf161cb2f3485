/// What must hold of every ray, whatever its bits are.
#pragma once

#include <span>

#include "stbvh/structure.h"
#include "unculled.h"

namespace stbvh::fuzz {

/// Traces `ray` in every way there is; aborts, having printed it, where the answers contradict each other or
/// `unculled`, which holds the valid triangles of the structure.
void check_ray(const Structure& structure, const test::Unculled& unculled, const Ray& ray);

/// Traces `rays` in flight together; aborts where that answers otherwise than one by one.
void check_batch(const Structure& structure, std::span<const Ray> rays);

/// What must hold of a structure of the precision kFast: hits are in the ray's range, filtered or not.
void check_fast_ray(const Structure& fast, const Ray& ray);

}  // namespace stbvh::fuzz
