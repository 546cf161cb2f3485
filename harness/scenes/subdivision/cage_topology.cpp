#include "harness/scenes/subdivision/cage_topology.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <memory>
#include <string>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/subdivision/cage_check.h"
#include "harness/scenes/subdivision/weight_recorder.h"

namespace stbvh::harness::subdivision {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;
using Refiner = std::unique_ptr<Far::TopologyRefiner>;

/// What OpenSubdiv last said on this thread; without our callbacks it would print it.
thread_local std::string complaint;

void listen_to_opensubdiv() {
  static const bool once = [] {
    Far::SetErrorCallback([](Far::ErrorType, const char* message) { complaint = message; });
    Far::SetWarningCallback([](const char* message) { complaint = message; });
    return true;
  }();
  static_cast<void>(once);
  complaint.clear();
}

Sdc::Options scheme_options(SubdivisionCage::Boundary boundary) {
  Sdc::Options options;
  switch (boundary) {
    case SubdivisionCage::Boundary::kNone:
      options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_NONE);
      break;
    case SubdivisionCage::Boundary::kEdgeOnly:
      options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
      break;
    case SubdivisionCage::Boundary::kEdgeAndCorner:
      options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
      break;
  }
  return options;
}

float capped(float sharpness) {
  return std::min(sharpness, 10.0f);  // OpenSubdiv's infinity
}

Refiner make_refiner(const SubdivisionCage& cage) {
  const std::vector<int> sizes(cage.face_sizes.begin(), cage.face_sizes.end());
  const std::vector<int> corners(cage.face_vertices.begin(), cage.face_vertices.end());
  const std::vector<int> holes(cage.holes.begin(), cage.holes.end());
  std::vector<int> creased_edges, creased_vertices;
  std::vector<float> edge_sharpness, vertex_sharpness;
  for (const SubdivisionCage::Crease& crease : cage.edge_creases) {
    creased_edges.insert(creased_edges.end(), {static_cast<int>(crease.a), static_cast<int>(crease.b)});
    edge_sharpness.push_back(capped(crease.sharpness));
  }
  for (const SubdivisionCage::Corner& corner : cage.vertex_creases) {
    creased_vertices.push_back(static_cast<int>(corner.vertex));
    vertex_sharpness.push_back(capped(corner.sharpness));
  }
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(cage.steps.front().size());
  descriptor.numFaces = static_cast<int>(sizes.size());
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = corners.data();
  descriptor.numCreases = static_cast<int>(edge_sharpness.size());
  descriptor.creaseVertexIndexPairs = creased_edges.data();
  descriptor.creaseWeights = edge_sharpness.data();
  descriptor.numCorners = static_cast<int>(vertex_sharpness.size());
  descriptor.cornerVertexIndices = creased_vertices.data();
  descriptor.cornerWeights = vertex_sharpness.data();
  descriptor.numHoles = static_cast<int>(holes.size());
  descriptor.holeIndices = holes.data();
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const bool is_loop = cage.scheme == SubdivisionCage::Scheme::kLoop;
  Factory::Options options(is_loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK, scheme_options(cage.boundary));
  options.validateFullTopology = true;
  listen_to_opensubdiv();
  Refiner refiner(Factory::Create(descriptor, options));
  if (!refiner) fail("OpenSubdiv cannot refine the cage: {}", complaint);
  for (const SubdivisionCage::Crease& crease : cage.edge_creases) {
    const Far::Index edge =
        refiner->GetLevel(0).FindEdge(static_cast<int>(crease.a), static_cast<int>(crease.b));
    if (edge == Far::INDEX_INVALID) {
      fail("a crease of the cage lies between vertices {} and {}, which no edge joins", crease.a, crease.b);
    }
  }
  return refiner;
}

/// Vertex i is i.
struct OwnIndex {
  std::size_t operator[](int vertex) const { return static_cast<std::size_t>(vertex); }
};

std::vector<bool> all_vertices(const Far::TopologyLevel& level) {
  return std::vector<bool>(static_cast<std::size_t>(level.GetNumVertices()), true);
}

/// A level's vertices by those of the level before, and by the points of its faces, which come first where
/// there are any.
WeightedSums refined_sums(const Far::TopologyRefiner& refiner, int level) {
  const auto faces = static_cast<std::size_t>(refiner.GetLevel(level - 1).GetNumFaces());
  const bool has_face_points = refiner.GetSchemeType() == Sdc::SCHEME_CATMARK;
  WeightRecorder recorder(all_vertices(refiner.GetLevel(level)), has_face_points ? faces : 0);
  Far::PrimvarRefinerReal<double>(refiner).Interpolate(level, OwnIndex{}, recorder);
  check_cancelled();
  return recorder.take();
}

/// The face of the cage that each face of the level comes of.
std::vector<std::uint32_t> cage_faces(const Far::TopologyRefiner& refiner, int level) {
  std::vector<std::uint32_t> faces(static_cast<std::size_t>(refiner.GetLevel(level).GetNumFaces()));
  for (std::size_t face = 0; face < faces.size(); ++face) {
    auto ancestor = static_cast<Far::Index>(face);
    for (int l = level; l > 0; --l) ancestor = refiner.GetLevel(l).GetFaceParentFace(ancestor);
    faces[face] = static_cast<std::uint32_t>(ancestor);
  }
  return faces;
}

/// Triangles of the faces that are no holes: fans.
void add_triangles(const Far::TopologyRefiner& refiner, int l, CageTopology& result) {
  const Far::TopologyLevel& level = refiner.GetLevel(l);
  const std::vector<std::uint32_t> origins = cage_faces(refiner, l);
  for (int face = 0; face < level.GetNumFaces(); ++face) {
    if (level.IsFaceHole(face)) continue;
    const Far::ConstIndexArray corners = level.GetFaceVertices(face);
    for (int i = 2; i < corners.size(); ++i) {
      for (const int corner : {corners[0], corners[i - 1], corners[i]})
        result.indices.push_back(static_cast<std::uint32_t>(corner));
      result.faces.push_back(origins[static_cast<std::size_t>(face)]);
    }
  }
}

/// The level's faces on the vertices of the next: limit masks exist for quads only, which all faces are
/// there.
void use_child_vertices(const Far::TopologyLevel& level, std::vector<std::uint32_t>& indices) {
  for (std::uint32_t& index : indices) {
    index = static_cast<std::uint32_t>(level.GetVertexChildVertex(static_cast<int>(index)));
  }
}

}  // namespace

std::size_t refined_face_count(const SubdivisionCage& cage, unsigned level) {
  if (cage.scheme == SubdivisionCage::Scheme::kLoop) return cage.face_sizes.size() << (2 * level);
  return level == 0 ? cage.face_sizes.size() : cage.face_vertices.size() << (2 * (level - 1));
}

CageTopology refine_topology(const SubdivisionCage& cage, unsigned level) {
  const Refiner refiner = make_refiner(cage);
  const unsigned refined_level = std::max(level, 1u);
  Far::TopologyRefiner::UniformOptions options(static_cast<int>(refined_level));
  options.orderVerticesFromFacesFirst = true;  // as they are used by others
  options.fullTopologyInLastLevel = true;
  refiner->RefineUniform(options);
  check_cancelled();
  CageTopology result;
  add_triangles(*refiner, static_cast<int>(level), result);
  if (result.indices.empty()) throw InvisibleCage("all faces of the cage are holes or lie at a border");
  if (level == 0) use_child_vertices(refiner->GetLevel(0), result.indices);

  const Far::TopologyLevel& last = refiner->GetLevel(static_cast<int>(refined_level));
  std::vector<bool> is_used(static_cast<std::size_t>(last.GetNumVertices()), false);
  for (const std::uint32_t index : result.indices) is_used[index] = true;
  for (unsigned l = 1; l <= refined_level; ++l)
    result.stages.push_back(refined_sums(*refiner, static_cast<int>(l)));
  WeightRecorder recorder(is_used);
  Far::PrimvarRefinerReal<double>(*refiner).Limit(OwnIndex{}, recorder);
  result.stages.push_back(recorder.take());
  check_cancelled();
  std::vector<std::uint32_t> renumbered(is_used.size(), 0);
  std::uint32_t next = 0;
  for (std::size_t v = 0; v < is_used.size(); ++v) renumbered[v] = is_used[v] ? next++ : 0;
  for (std::uint32_t& index : result.indices) index = renumbered[index];
  return result;
}

}  // namespace stbvh::harness::subdivision
