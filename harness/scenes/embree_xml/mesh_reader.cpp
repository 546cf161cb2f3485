#include "harness/scenes/embree_xml/mesh_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "harness/scenes/reach.h"
#include "harness/scenes/subdivision/degenerate_parts.h"
#include "harness/scenes/subdivision/subdivision.h"

namespace stbvh::harness::embree_xml {
namespace {

/// All steps of a mesh or cage.
std::vector<VertexBuffer> read_steps(Document& document, pugi::xml_node element) {
  std::vector<VertexBuffer> steps;
  if (const pugi::xml_node animation = element.child("animated_positions")) {
    for (const pugi::xml_node step : animation.children()) {
      if (step.type() != pugi::node_element) continue;
      if (steps.size() == kMaxSceneSteps) fail(element, "a mesh has more than {} steps", kMaxSceneSteps);
      steps.push_back(document.positions(step));
    }
  } else {
    for (const char* const name : {"positions", "positions2"}) {
      if (const pugi::xml_node step = element.child(name)) steps.push_back(document.positions(step));
    }
  }
  if (steps.empty()) fail(element, "a <{}> has no positions", element.name());
  for (const VertexBuffer& step : steps) {
    if (step.size() != steps.front().size())
      fail(element, "a <{}> has {} positions in its first step and {} in another", element.name(),
           steps.front().size(), step.size());
  }
  return steps;
}

void check_indices(pugi::xml_node element, const std::vector<std::uint32_t>& indices, std::size_t vertices) {
  for (const std::uint32_t index : indices) {
    if (index >= vertices)
      fail(element, "a <{}> has the index {}, but only {} vertices", element.name(), index, vertices);
  }
}

Mesh lamp(Document& document, pugi::xml_node element, std::vector<std::uint32_t> indices,
          std::span<const Vec3> corners) {
  const Affine space = read_affine_space(document, element.child("AffineSpace"));
  Mesh mesh;
  mesh.indices = std::move(indices);
  VertexBuffer& step = mesh.steps.emplace_back(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 p = space.apply(corners[i]);
    step[i] = to_float(p);
    for (const double x : {p.x, p.y, p.z}) {
      if (!is_within_reach(x)) fail(element, "a <{}> is too far away", element.name());
    }
  }
  mesh.material.color = {0, 0, 0};
  mesh.material.emission = read_color(document, element, "L");
  return mesh;
}

Affine rotation(std::span<const float> axis, std::span<const float> point, float degrees, pugi::xml_node at) {
  const double length =
      std::hypot(static_cast<double>(axis[0]), static_cast<double>(axis[1]), static_cast<double>(axis[2]));
  if (!(length > 0)) fail(at, "an <AffineSpace> turns about an axis without length");
  const std::array<double, 3> a{static_cast<double>(axis[0]) / length, static_cast<double>(axis[1]) / length,
                                static_cast<double>(axis[2]) / length};
  const double angle = static_cast<double>(degrees) * kPi / 180;
  const double c = std::cos(angle), s = std::sin(angle);
  Affine r;  // Rodrigues' formula
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) r.row[i][j] = (1 - c) * a[i] * a[j] + (i == j ? c : 0);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    r.row[j][k] -= s * a[i];
    r.row[k][j] += s * a[i];
  }
  const Vec3 p = to_double({point[0], point[1], point[2]}), moved = p - r.apply(p);
  r.row[0][3] = moved.x;
  r.row[1][3] = moved.y;
  r.row[2][3] = moved.z;
  return r;
}

constexpr std::array<float, 3> kOrigin{0, 0, 0};

}  // namespace

Affine read_affine_space(Document& document, pugi::xml_node element) {
  Affine map;
  const auto has = [&](const char* name) { return !element.attribute(name).empty(); };
  if (has("translate")) {
    const auto by = float_attribute(element, "translate", 3);
    for (std::size_t i = 0; i < 3; ++i) map.row[i][3] = static_cast<double>(by[i]);
    return map;
  }
  if (has("scale")) {
    const auto by = float_attribute(element, "scale", 3);
    for (std::size_t i = 0; i < 3; ++i) map.row[i][i] = static_cast<double>(by[i]);
    return map;
  }
  constexpr std::array<const char*, 3> kTurns{"rotate_x", "rotate_y", "rotate_z"};
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<float, 3> axis{};
    axis[i] = 1;
    if (has(kTurns[i])) return rotation(axis, kOrigin, float_attribute(element, kTurns[i], 1)[0], element);
  }
  if (has("angle")) {
    const auto point = has("point") ? float_attribute(element, "point", 3)
                                    : std::vector<float>(kOrigin.begin(), kOrigin.end());
    return rotation(float_attribute(element, "axis", 3), point, float_attribute(element, "angle", 1)[0],
                    element);
  }
  const std::vector<float> values = document.floats(element, 12);
  if (values.size() != 12 ||
      !std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
    fail(element, "an <AffineSpace> has {} numbers; it takes 12 finite ones", values.size());
  for (std::size_t i = 0; i < 12; ++i) map.row[i / 4][i % 4] = static_cast<double>(values[i]);
  return map;
}

Vec3f read_color(Document& document, pugi::xml_node parent, const char* name) {
  const std::vector<float> values = document.floats(parent.child(name), 3);
  const auto is_light = [](float v) { return std::isfinite(v) && v >= 0; };
  if (values.size() != 3 || !std::all_of(values.begin(), values.end(), is_light))
    fail(parent, "a <{}> needs three numbers from 0 on in its <{}>", parent.name(), name);
  return {values[0], values[1], values[2]};
}

Mesh read_triangle_mesh(Document& document, pugi::xml_node element) {
  Mesh mesh;
  mesh.indices = document.integers(element.child("triangles"), 3);
  if (mesh.indices.empty()) return mesh;
  mesh.steps = read_steps(document, element);
  check_indices(element, mesh.indices, mesh.steps.front().size());
  return mesh;
}

Mesh read_quad_mesh(Document& document, pugi::xml_node element) {
  Mesh mesh;
  const std::vector<std::uint32_t> quads = document.integers(element.child("indices"), 4);
  if (quads.empty()) return mesh;
  mesh.steps = read_steps(document, element);
  check_indices(element, quads, mesh.steps.front().size());
  for (std::size_t i = 0; i < quads.size(); i += 4) {
    const std::uint32_t a = quads[i], b = quads[i + 1], c = quads[i + 2], d = quads[i + 3];
    mesh.indices.insert(mesh.indices.end(), {a, b, d});
    if (c != d) mesh.indices.insert(mesh.indices.end(), {c, d, b});  // else it stands for one triangle
  }
  return mesh;
}

Mesh read_quad_light(Document& document, pugi::xml_node element) {
  constexpr std::array<Vec3, 4> kCorners{{{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}};
  return lamp(document, element, {0, 1, 3, 2, 3, 1}, kCorners);
}

Mesh read_triangle_light(Document& document, pugi::xml_node element) {
  constexpr std::array<Vec3, 3> kCorners{{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}}};
  return lamp(document, element, {0, 1, 2}, kCorners);
}

namespace {

SubdivisionCage::Boundary boundary_of(pugi::xml_node indices, const Warn& warn) {
  const std::string_view mode = indices.attribute("subdiv_mode").value();
  if (mode.empty() || mode == "smooth") return SubdivisionCage::Boundary::kEdgeOnly;
  if (mode == "no_boundary") return SubdivisionCage::Boundary::kNone;
  if (mode == "pin_boundary" || mode == "pin_all")
    warn(fmt::format("The subdivision mode {} is read as pin_corners.", mode));
  else if (mode != "pin_corners")
    fail(indices, "the subdivision mode \"{}\" is unknown", mode);
  return SubdivisionCage::Boundary::kEdgeAndCorner;
}

/// Weights of creases; beyond 10 all are infinitely sharp (DeRose, Kass, Truong 1998; OpenSubdiv).
float sharpness(const std::vector<float>& weights, std::size_t i, pugi::xml_node at) {
  if (i >= weights.size()) fail(at, "a <{}> has fewer weights than creases", at.name());
  if (std::isnan(weights[i]) || weights[i] < 0)
    fail(at, "a <{}> has a crease of weight {}", at.name(), weights[i]);
  return std::min(weights[i], 10.0f);
}

SubdivisionCage read_cage(Document& document, pugi::xml_node element, const Warn& warn) {
  SubdivisionCage cage;
  cage.face_sizes = document.integers(element.child("faces"), 1);
  cage.face_vertices = document.integers(element.child("position_indices"), 1);
  cage.boundary = boundary_of(element.child("position_indices"), warn);
  cage.holes = document.integers(element.child("holes"), 1);
  const auto edges = document.integers(element.child("edge_creases"), 2);
  const auto edge_weights = document.floats(element.child("edge_crease_weights"), 1);
  for (std::size_t i = 0; i < edges.size() / 2; ++i)
    cage.edge_creases.push_back({edges[2 * i], edges[2 * i + 1], sharpness(edge_weights, i, element)});
  const auto corners = document.integers(element.child("vertex_creases"), 1);
  const auto corner_weights = document.floats(element.child("vertex_crease_weights"), 1);
  for (std::size_t i = 0; i < corners.size(); ++i)
    cage.vertex_creases.push_back({corners[i], sharpness(corner_weights, i, element)});
  if (!cage.face_sizes.empty()) cage.steps = read_steps(document, element);
  return cage;
}

}  // namespace

Mesh read_subdivision_mesh(Document& document, pugi::xml_node element, const Warn& warn, CageLosses& losses) {
  SubdivisionCage cage = read_cage(document, element, warn);
  if (cage.face_sizes.empty()) return {};
  check_indices(element, cage.face_vertices, cage.steps.front().size());
  const DegenerateParts parts = take_out_degenerate_parts(cage);
  losses.faces += parts.faces;
  losses.creases += parts.creases;
  try {
    if (cage.face_sizes.empty()) throw InvisibleCage("all faces of the cage are degenerate");
    Mesh mesh = refine(cage, RefinementTarget{});
    for (std::uint32_t& face : mesh.faces) face = parts.numbers[face];
    return mesh;
  } catch (const InvisibleCage&) {
    ++losses.cages;
    return {};
  } catch (const std::invalid_argument& bad_cage) {
    fail(element, "a <SubdivisionMesh> cannot be refined: {}", bad_cage.what());
  }
}

}  // namespace stbvh::harness::embree_xml
