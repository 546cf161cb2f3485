/// What the callbacks of a user geometry see: one immutable snapshot for each commit.
#pragma once

#include <memory>
#include <vector>

#include "plugin/embree_api.h"
#include "plugin/motion_grid.h"
#include "stbvh/structure.h"

namespace stbvh::plugin {

/// The part of a mesh that is needed after the kernels have found a hit on it.
struct PublishedMesh {
  unsigned geom_id;  ///< RTC_INVALID_GEOMETRY_ID: the one the callback is given
  void* user_ptr;
  RTCFilterFunctionN intersect_filter;
  RTCFilterFunctionN occluded_filter;
  bool takes_query_filters = false;  ///< also those that are not for all meshes
};

/// The user data of the RTCGeometry points to one of these. Without a structure it is empty and hits nothing.
struct Published {
  std::vector<PublishedMesh> meshes;
  unsigned mask =
      0;  ///< union of the meshes': Embree tests it before it calls, the kernels test each mesh's own
  bool has_intersect_filters = false;
  bool has_occluded_filters = false;
  bool runs_query_filters = true;          ///< those that rays bring with their queries
  bool meshes_take_query_filters = false;  ///< some, also those that are not for all meshes
  /// What filters are given for a mesh's user_ptr, asked once for each hit that they see; null: the pointer.
  void* (*filter_user_ptr)(void* user_ptr) = nullptr;
  MotionGrid grid{{0.0f, 1.0f}, {Box3f::empty()}};
  std::shared_ptr<Structure> structure;  ///< the next may show it too, changed

  void add(const PublishedMesh& mesh, unsigned mesh_mask) {
    meshes.push_back(mesh);
    mask |= mesh_mask;
    has_intersect_filters |= mesh.intersect_filter != nullptr;
    has_occluded_filters |= mesh.occluded_filter != nullptr;
    meshes_take_query_filters |= mesh.takes_query_filters;
  }
};

}  // namespace stbvh::plugin
