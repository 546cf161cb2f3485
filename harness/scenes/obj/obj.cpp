#include "harness/scenes/obj/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <new>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "harness/files/text.h"
#include "harness/scenes/cancellation.h"
#include "harness/scenes/finite_check.h"
#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/name_list.h"
#include "harness/scenes/obj/mtl_file.h"
#include "harness/scenes/obj/obj_file.h"
#include "harness/scenes/obj/obj_sequence.h"
#include "harness/scenes/obj/polygon_cutter.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw SceneFileError(fmt::format(text, std::forward<Args>(args)...));
}

/// The faces of one material.
struct Part {
  std::string material;
  std::vector<std::uint32_t> indices;   ///< of the file's vertices, 3 for each triangle
  std::vector<std::uint32_t> faces;     ///< of the file, of each triangle
  std::vector<std::uint32_t> vertices;  ///< of the file, those of the mesh in its order
};

/// The faces of a file as triangles, by material, in the order in which materials come first.
class Triangulation {
 public:
  Triangulation(const ObjFile& file) : file_(file) {
    auto run = file.material_runs.begin();
    std::size_t part = part_of("");
    std::size_t first_corner = 0;
    for (std::size_t face = 0; face < file.face_sizes.size(); ++face) {
      check_cancelled();
      for (; run != file.material_runs.end() && run->first_face == face; ++run) part = part_of(run->name);
      add_face(std::span(file.corners).subspan(first_corner, file.face_sizes[face]), parts_[part]);
      parts_[part].faces.resize(parts_[part].indices.size() / 3, static_cast<std::uint32_t>(face));
      first_corner += file.face_sizes[face];
    }
    std::erase_if(parts_, [](const Part& p) { return p.indices.empty(); });
  }

  /// Tells how many faces have more than one meaning.
  void tell(const fs::path& path, const SceneWarning& warn) const {
    if (bent_ > 0) {
      warn(fmt::format(
          "{}: faces that are not flat: {}; how they are cut into triangles is one of several ways",
          path.string(), bent_));
    }
    if (crossing_ > 0) {
      warn(fmt::format("{}: faces that cross themselves: {}; their triangles overlap, or leave gaps",
                       path.string(), crossing_));
    }
  }

  std::vector<Part> take() { return std::move(parts_); }

 private:
  std::size_t part_of(const std::string& material) {
    const auto [known, is_new] = part_of_material_.try_emplace(material, parts_.size());
    if (is_new) parts_.push_back({material, {}, {}, {}});
    return known->second;
  }

  void add_face(std::span<const std::uint32_t> face, Part& part) {
    if (face.size() == 3) {
      part.indices.insert(part.indices.end(), face.begin(), face.end());
      return;
    }
    corners_.clear();
    for (const std::uint32_t vertex : face) corners_.push_back(to_double(file_.positions[vertex]));
    triangles_.clear();
    const PolygonFlaws flaws = cut_polygon(corners_, triangles_);
    bent_ += flaws.is_bent ? 1u : 0u;
    crossing_ += flaws.crosses_itself ? 1u : 0u;
    for (const std::uint32_t corner : triangles_) part.indices.push_back(face[corner]);
  }

  const ObjFile& file_;
  std::vector<Part> parts_;
  std::map<std::string, std::size_t> part_of_material_;
  std::vector<Vec3> corners_;             ///< of the face
  std::vector<std::uint32_t> triangles_;  ///< of the face
  std::size_t bent_ = 0, crossing_ = 0;
};

/// Gives each part the vertices that it uses; one that is alone keeps all.
void number_vertices(std::vector<Part>& parts, std::size_t vertex_count) {
  if (parts.size() == 1) {
    parts[0].vertices.resize(vertex_count);
    std::iota(parts[0].vertices.begin(), parts[0].vertices.end(), 0);
    return;
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numbers(vertex_count, kNone);
  for (Part& part : parts) {
    for (std::uint32_t& index : part.indices) {
      if (numbers[index] == kNone) {
        numbers[index] = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(index);
      }
      index = numbers[index];
    }
    for (const std::uint32_t vertex : part.vertices) numbers[vertex] = kNone;
  }
}

/// Each file that a library names may have blanks in its name, or stand beside others.
std::vector<fs::path> library_files(const fs::path& folder, const std::string& named) {
  std::error_code ignored;
  std::string_view rest = named;
  for (const std::string_view name : {rest, without_trailing_blanks(without_comment(rest))}) {
    if (fs::exists(folder / name, ignored)) return {folder / name};
    rest = name;
  }
  std::vector<fs::path> files;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest))
    files.push_back(folder / word);
  return files;
}

/// The materials of all libraries; those that cannot be read are told of, as their surfaces keep their shape.
std::map<std::string, Material> read_materials(const ObjFile& file, const fs::path& path,
                                               const SceneWarning& warn) {
  std::map<std::string, Material> materials;
  std::set<fs::path> known;
  NameList problems;
  for (const std::string& library : file.material_libraries) {
    for (const fs::path& library_path : library_files(path.parent_path(), library)) {
      if (!known.insert(library_path).second) continue;
      try {
        materials.merge(read_mtl_file(library_path, warn));
      } catch (const SceneFileError& problem) {
        problems.add(problem.what());
      }
    }
  }
  if (problems.count() > 0) {
    warn(fmt::format("{}: materials of {} librar{} are read as diffuse grey: {}", path.string(),
                     problems.count(), problems.count() == 1 ? "y" : "ies", problems.text()));
  }
  return materials;
}

std::vector<Mesh> make_meshes(const std::vector<Part>& parts,
                              const std::map<std::string, Material>& materials, const std::string& otherwise,
                              const fs::path& path, const SceneWarning& warn) {
  std::vector<Mesh> meshes;
  NameList undefined;
  for (const Part& part : parts) {
    Mesh& mesh = meshes.emplace_back();
    mesh.name = part.material.empty() || parts.size() == 1 ? otherwise : part.material;
    mesh.indices = part.indices;
    mesh.faces = part.faces;
    const auto known = materials.find(part.material);
    if (known != materials.end()) {
      mesh.material = known->second;
    } else if (!materials.empty() && !part.material.empty()) {
      undefined.add(fmt::format("\"{}\"", part.material));
    }
  }
  warn_of_undefined(undefined, path, warn);
  return meshes;
}

void add_step(const std::vector<Part>& parts, const std::vector<Vec3f>& positions,
              std::vector<Mesh>& meshes) {
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const std::vector<std::uint32_t>& vertices = parts[m].vertices;
    VertexBuffer& step = meshes[m].steps.emplace_back(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) step[i] = positions[vertices[i]];
  }
}

void check_same_topology(const fs::path& path, const ObjFile& file, const fs::path& first_path,
                         const ObjFile& first) {
  const auto check_count = [&](const char* what, std::size_t count, std::size_t first_count) {
    if (count != first_count)
      fail("{}: it has {} {}, but {} has {}", path.string(), count, what, first_path.string(), first_count);
  };
  check_count("vertices", file.positions.size(), first.positions.size());
  check_count("faces", file.face_sizes.size(), first.face_sizes.size());
  std::size_t corner = 0;
  for (std::size_t face = 0; face < file.face_sizes.size(); ++face) {
    const std::size_t size = file.face_sizes[face];
    const auto begin = file.corners.begin() + static_cast<std::ptrdiff_t>(corner);
    if (size != first.face_sizes[face] ||
        !std::equal(begin, begin + static_cast<std::ptrdiff_t>(size),
                    first.corners.begin() + static_cast<std::ptrdiff_t>(corner)))
      fail("{}: its face {} has other corners than in {}", path.string(), face, first_path.string());
    corner += size;
  }
}

Scene load(const std::string& name, const SceneWarning& warn, std::size_t number_step) {
  const std::vector<fs::path> files = find_obj_files(name, warn, number_step);
  const ObjFile first = read_obj_file(files[0]);
  if (first.positions.size() * sizeof(Vec3f) * files.size() > kMaxSceneFileBytes)
    fail("{}: its vertices need more than {} GB", name, kMaxSceneFileBytes >> 30);
  if (!first.left_out.empty())
    warn(fmt::format("{}: left out, as only faces are read: {}", files[0].string(), first.left_out));
  Triangulation triangulation(first);
  triangulation.tell(files[0], warn);
  std::vector<Part> parts = triangulation.take();
  number_vertices(parts, first.positions.size());
  Scene scene;
  scene.name = obj_scene_name(name);
  const auto materials = read_materials(first, files[0], warn);
  scene.meshes = make_meshes(parts, materials, scene.name, files[0], warn);
  add_step(parts, first.positions, scene.meshes);
  for (std::size_t i = 1; i < files.size(); ++i) {
    const ObjFile file = read_obj_file(files[i]);
    check_same_topology(files[i], file, files[0], first);
    add_step(parts, file.positions, scene.meshes);
  }
  leave_out_invalid_triangles(scene, name, warn);
  if (scene.meshes.empty()) fail("{}: nothing in it can be shown", name);
  scene.camera = gltf::framing_camera(scene);
  return scene;
}

}  // namespace

Scene load_obj(const std::string& name, const SceneWarning& warn, std::size_t number_step) {
  std::set<std::string> told;
  const auto once = [&](const std::string& sentence) {
    if (told.insert(sentence).second && warn) warn(sentence);
  };
  try {
    return load(name, once, number_step);
  } catch (const std::bad_alloc&) {
    fail("{}: there is not enough memory for it", name);
  }
}

}  // namespace stbvh::harness
