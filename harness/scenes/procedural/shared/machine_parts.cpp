#include "harness/scenes/procedural/shared/machine_parts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "harness/scenes/cancellation.h"

namespace stbvh::harness {
namespace {

/// Quads of a patch along u and v.
struct Cut {
  std::size_t u, v;
  std::size_t triangles() const { return 2 * u * v; }
};

std::size_t cut_length(double length, std::size_t least, double density) {
  return std::max(least, static_cast<std::size_t>(std::llround(length * density)));
}

std::vector<Cut> cut_all(const std::vector<Part>& parts, double density) {
  std::vector<Cut> cuts;
  for (const Part& part : parts) {
    for (const Patch& patch : part.patches) {
      cuts.push_back({cut_length(patch.length_u, patch.min_u, density),
                      cut_length(patch.length_v, patch.min_v, density)});
    }
  }
  return cuts;
}

std::size_t total(const std::vector<Cut>& cuts) {
  std::size_t sum = 0;
  for (const Cut& cut : cuts) sum += cut.triangles();
  return sum;
}

/// Spends what is left of `triangles` on one more row or column here and there.
void top_up(const std::vector<Part>& parts, std::size_t triangles, std::vector<Cut>& cuts) {
  std::size_t sum = total(cuts);
  std::size_t i = 0;
  for (const Part& part : parts) {
    for (const Patch& patch : part.patches) {
      Cut& cut = cuts[i++];
      if (patch.length_u > 0 && sum + 2 * cut.v <= triangles) {
        sum += 2 * cut.v;
        ++cut.u;
      } else if (patch.length_v > 0 && sum + 2 * cut.u <= triangles) {
        sum += 2 * cut.u;
        ++cut.v;
      }
    }
  }
}

/// The finest cut by one density that does not exceed `triangles`, topped up.
std::vector<Cut> fit_cuts(const std::vector<Part>& parts, std::size_t triangles) {
  std::vector<Cut> best = cut_all(parts, 0.0);
  double low = 1e-6, high = 1e6;
  for (int i = 0; i < 60; ++i) {
    check_cancelled();
    const double middle = std::sqrt(low * high);
    std::vector<Cut> cuts = cut_all(parts, middle);
    if (total(cuts) <= triangles) {
      best = std::move(cuts);
      low = middle;
    } else {
      high = middle;
    }
  }
  top_up(parts, triangles, best);
  return best;
}

struct VertexGrid {
  std::size_t columns, rows;
  std::size_t size() const { return columns * rows; }
};

VertexGrid vertex_grid(const Patch& patch, Cut cut) {
  return {patch.wrap == Wrap::kNone ? cut.u + 1 : cut.u, patch.wrap == Wrap::kBoth ? cut.v : cut.v + 1};
}

/// Writes one patch into its mesh, behind `first_vertex` and `first_triangle`.
void fill_patch(Mesh& mesh, const Patch& patch, const Motion& motion, Cut cut, std::size_t first_vertex,
                std::size_t first_triangle) {
  const Shape shape = make_grid(cut.u, cut.v, patch.at, patch.wrap);
  for (std::size_t i = 0; i < shape.indices.size(); ++i) {
    mesh.indices[3 * first_triangle + i] = shape.indices[i] + static_cast<std::uint32_t>(first_vertex);
  }
  for (std::size_t k = 0; k < mesh.steps.size(); ++k) {
    VertexBuffer& buffer = mesh.steps[k];
    const PointMap map = motion ? motion(step_time(k, mesh.steps.size())) : PointMap{};
    for (std::size_t i = 0; i < shape.positions.size(); ++i) {
      buffer[first_vertex + i] = to_float(map ? map(shape.positions[i]) : shape.positions[i]);
    }
  }
}

/// What shines does so by its name, in all machine scenes alike; the rest is matt.
Material material_of(const Part& part) {
  constexpr std::array kMetals{"brass", "steel", "chrome", "hubs"};
  constexpr std::array kGlazed{"glass",      "window glass", "car windows", "green glass", "amber glass",
                               "red cars",   "blue cars",    "white cars",  "leather",     "green cladding",
                               "black iron", "red paint",    "blue paint",  "maroon"};
  const auto is_one_of = [&](const auto& names) {
    return std::find(names.begin(), names.end(), part.name) != names.end();
  };
  Material material;
  material.color = to_float(part.color);
  if (is_one_of(kMetals)) {
    material.kind = Material::Kind::kGlossy;
    material.roughness = 0.45f;
    material.index_of_refraction = 3;
  } else if (is_one_of(kGlazed)) {
    material.kind = Material::Kind::kGlossy;
    material.roughness = 0.2f;
  } else if (part.name == "mirrors") {
    material.kind = Material::Kind::kMirror;
  }
  return material;
}

Mesh make_mesh(const Part& part, const Cut* cuts) {
  std::vector<std::size_t> first_vertex{0}, first_triangle{0};
  for (std::size_t i = 0; i < part.patches.size(); ++i) {
    first_vertex.push_back(first_vertex.back() + vertex_grid(part.patches[i], cuts[i]).size());
    first_triangle.push_back(first_triangle.back() + cuts[i].triangles());
  }
  Mesh mesh;
  mesh.name = part.name;
  mesh.material = material_of(part);
  mesh.indices.resize(3 * first_triangle.back());
  for (std::size_t k = 0; k < part.steps; ++k) mesh.steps.emplace_back(first_vertex.back());
  for_all(part.patches.size(), [&](std::size_t i) {
    fill_patch(mesh, part.patches[i], part.motions[i], cuts[i], first_vertex[i], first_triangle[i]);
  });
  return mesh;
}

}  // namespace

Motion rigid_motion(std::function<Rigid(double)> pose) {
  return [pose = std::move(pose)](double time) -> PointMap {
    return [rigid = pose(time)](Vec3 p) { return rigid.apply(p); };
  };
}

Motion compose(Motion outer, Motion inner) {
  if (!outer) return inner;
  if (!inner) return outer;
  return [outer = std::move(outer), inner = std::move(inner)](double time) -> PointMap {
    return [second = outer(time), first = inner(time)](Vec3 p) { return second(first(p)); };
  };
}

void Part::add(const Patches& added, const Placement& placement) {
  for (Patch patch : added) {
    patch.length_u *= placement.detail;
    patch.length_v *= placement.detail;
    patch.at = [at = std::move(patch.at), pose = placement.pose](double u, double v) {
      return pose.apply(at(u, v));
    };
    patches.push_back(std::move(patch));
    motions.push_back(placement.motion);
  }
}

std::vector<Mesh> tessellate(const std::vector<Part>& parts, std::size_t triangles) {
  const std::vector<Cut> cuts = fit_cuts(parts, triangles);
  std::vector<Mesh> meshes;
  std::size_t first = 0;
  for (const Part& part : parts) {
    if (!part.patches.empty()) meshes.push_back(make_mesh(part, cuts.data() + first));
    first += part.patches.size();
  }
  return meshes;
}

std::size_t scaled_count(double count, double scale) {
  return static_cast<std::size_t>(std::llround(std::max(count * scale, 1.0)));
}

}  // namespace stbvh::harness
