/// The references that a build begins with: all meshlets of all meshes, over all times.
#pragma once

#include <span>

#include "builder/build_context.h"
#include "builder/reference_set.h"

namespace stbvh {

/// Over the times at which any mesh is alive, within [0, 1]; into `storage`, which holds one for each meshlet
/// of the context. Those of one mesh stand next to each other; meshes that are never alive have none.
ReferenceSet make_references(BuildContext& context, std::span<Reference> storage);

}  // namespace stbvh
