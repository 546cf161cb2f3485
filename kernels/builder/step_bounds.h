/// Bounds of a mesh at its steps.
#pragma once

#include <span>
#include <vector>

#include "builder/build_mesh.h"
#include "layout/meshlet.h"

namespace stbvh {

struct BuildContext;

/// The boxes of `meshlets`, all those of `mesh`, at each step; empty ones without any.
std::vector<Box3f> step_bounds(const BuildMesh& mesh, std::span<const Meshlet> meshlets);

/// Tells callbacks.step_bounds, if there is one, of all meshes of a build.
void tell_step_bounds(const BuildContext& context, const BuildCallbacks& callbacks);

/// The same, for a mesh without invalid vertices and not in parts, of the vertices that its triangles use.
std::vector<Box3f> step_bounds(const BuildMesh& mesh);

}  // namespace stbvh
