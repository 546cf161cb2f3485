/// Bounds of a mesh at its steps.
#pragma once

#include <functional>
#include <vector>

#include "stbvh/mesh_view.h"

namespace stbvh::plugin {

/// For each step of `mesh` the exact box around the vertices of its valid triangles; empty boxes without any.
///
/// A triangle is valid if its indices are in range and its vertices in all steps finite and smaller than
/// kMaxCoordinate. `temporary_memory` is told of the scratch memory (+, then -); returning false throws
/// std::bad_alloc.
std::vector<Box3f> step_bounds(const MeshView& mesh,
                               const std::function<bool(std::ptrdiff_t)>& temporary_memory);

}  // namespace stbvh::plugin
