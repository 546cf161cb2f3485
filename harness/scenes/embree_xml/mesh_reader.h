/// Meshes of Embree XML files.
#pragma once

#include <cstddef>
#include <pugixml.hpp>

#include "harness/scenes/embree_xml/document.h"
#include "harness/scenes/embree_xml/problem.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness::embree_xml {

/// What cages are shown without, as by Embree.
struct CageLosses {
  std::size_t cages = 0;    ///< whose faces are all holes, or at a border that is not shown, or degenerate
  std::size_t faces = 0;    ///< of fewer than three corners, or with a vertex twice
  std::size_t creases = 0;  ///< of edges that no face has
};

/// Geometry of a <TriangleMesh>, <QuadMesh> or <SubdivisionMesh>, without its material: quads are two
/// triangles each, as Embree splits them, cages are refined. No triangles where the file has none, or a cage
/// shows none. Throws Problem.
Mesh read_triangle_mesh(Document& document, pugi::xml_node element);
Mesh read_quad_mesh(Document& document, pugi::xml_node element);
Mesh read_subdivision_mesh(Document& document, pugi::xml_node element, const Warn& warn, CageLosses& losses);

/// The light of a <QuadLight> or <TriangleLight> as a mesh that shines, on both sides.
Mesh read_quad_light(Document& document, pugi::xml_node element);
Mesh read_triangle_light(Document& document, pugi::xml_node element);

/// The map in an <AffineSpace>: twelve numbers row by row, or one of its attributes. Throws Problem.
Affine read_affine_space(Document& document, pugi::xml_node element);

/// Three numbers in the text of `parent`'s child `name`. Throws Problem.
Vec3f read_color(Document& document, pugi::xml_node parent, const char* name);

}  // namespace stbvh::harness::embree_xml
