#include "harness/scenes/shots/shot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "harness/scenes/cancellation.h"
#include "harness/scenes/finite_check.h"
#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/obj/polygon_cutter.h"
#include "harness/scenes/shots/shot_records.h"
#include "harness/scenes/step_times.h"
#include "harness/scenes/vec3.h"

namespace stbvh::harness {
namespace {

using shots::MeshRecord;
using shots::RecordFile;
using shots::Tag;

[[noreturn]] void fail(const std::string& name, const std::string& problem) {
  throw SceneFileError(fmt::format("{}: it {}", name, problem));
}

class ShotLoader {
 public:
  ShotLoader(const std::string& name, const SceneWarning& warn) : name_(name), warn_(warn) {}

  Scene load(RecordFile& file, const std::string& ending) {
    bool is_whole = false;
    while (!is_whole && file.next()) {
      check_cancelled();
      is_whole = file.tag() == Tag::kEnd;
      take(file);
    }
    if (!is_whole && problem_.empty()) problem_ = ending;
    tell_of_polygons();
    leave_out_invalid_triangles(scene_, name_, warn_);
    if (scene_.meshes.empty() && !problem_.empty()) fail(name_, problem_);
    if (!problem_.empty()) tell(fmt::format("it {}; what was read before is shown", problem_));
    set_camera();
    return std::move(scene_);
  }

 private:
  void take(RecordFile& file) {
    switch (file.tag()) {
      case Tag::kEnd:
        break;
      case Tag::kMesh:
        add(file.mesh());
        break;
      case Tag::kCamera:
        cameras_ = file.camera();
        break;
      case Tag::kSun:
        scene_.directional_lights.push_back(file.sun());
        break;
      case Tag::kSky:
        add_sky(file.sky());
        break;
      case Tag::kWarning:
        tell(file.text());
        break;
      case Tag::kProblem:
        problem_ = file.text();
        break;
      default:
        throw shots::BadRecord("a record of another kind");
    }
  }

  void tell(const std::string& sentence) const {
    if (warn_) warn_(fmt::format("{}: {}", name_, sentence));
  }

  void add(MeshRecord record) {
    Mesh mesh = record.is_cage ? refined(record) : polygons(record);
    mesh.name = std::move(record.name);
    mesh.material = record.material;
    if (!record.step_times.empty()) {
      mesh.time_range = {record.step_times.front(), record.step_times.back()};
      if (!are_equidistant(record.step_times)) mesh.step_times = std::move(record.step_times);
    }
    if (!mesh.indices.empty()) scene_.meshes.push_back(std::move(mesh));
  }

  /// One that cannot be refined is shown as it is.
  Mesh refined(MeshRecord& record) {
    try {
      return refine(record.cage, {});
    } catch (const std::invalid_argument& problem) {
      tell(fmt::format("{} is shown as its cage: {}", record.name, problem.what()));
      return polygons(record);
    }
  }

  Mesh polygons(MeshRecord& record) {
    const SubdivisionCage& cage = record.cage;
    const VertexBuffer& positions = cage.steps.front();
    Mesh mesh;
    std::span<const std::uint32_t> rest = cage.face_vertices;
    std::vector<Vec3> corners;
    std::vector<std::uint32_t> triangles;
    for (std::uint32_t face = 0; face < cage.face_sizes.size(); ++face) {
      const auto vertices = rest.first(cage.face_sizes[face]);
      rest = rest.subspan(vertices.size());
      if (vertices.size() < 3) continue;
      triangles.assign({0, 1, 2});
      if (vertices.size() > 3) {
        corners.clear();
        for (const std::uint32_t vertex : vertices) corners.push_back(to_double(positions[vertex]));
        triangles.clear();
        const PolygonFlaws flaws = cut_polygon(corners, triangles);
        bent_ += flaws.is_bent ? 1u : 0u;
        crossing_ += flaws.crosses_itself ? 1u : 0u;
      }
      for (const std::uint32_t corner : triangles) mesh.indices.push_back(vertices[corner]);
      mesh.faces.insert(mesh.faces.end(), triangles.size() / 3, face);
    }
    mesh.steps = std::move(record.cage.steps);
    return mesh;
  }

  void tell_of_polygons() const {
    if (bent_ > 0)
      tell(fmt::format("faces that are not flat: {}; how they are cut into triangles is one of several ways",
                       bent_));
    if (crossing_ > 0)
      tell(fmt::format("faces that cross themselves: {}; their triangles overlap, or leave gaps", crossing_));
  }

  void add_sky(Vec3f radiance) {
    if (!scene_.environment)
      scene_.environment = Environment{.radiance = {0, 0, 0}, .width = 0, .height = 0, .pixels = {}};
    Vec3f& sum = scene_.environment->radiance;
    sum = {sum.x + radiance.x, sum.y + radiance.y, sum.z + radiance.z};
  }

  void set_camera() {
    const auto wrong = std::ranges::find_if(cameras_, [](const Camera& c) { return !problem_of(c).empty(); });
    if (cameras_.empty() || wrong != cameras_.end()) {
      if (!cameras_.empty())
        tell(fmt::format("its camera {}; another one shows everything", problem_of(*wrong)));
      scene_.camera = gltf::framing_camera(scene_);
      scene_.is_framed = true;
      return;
    }
    scene_.camera = cameras_.front();
    if (cameras_.size() > 1) scene_.camera_steps = std::move(cameras_);
  }

  const std::string& name_;
  const SceneWarning& warn_;
  Scene scene_;
  std::vector<Camera> cameras_;
  std::string problem_;
  std::size_t bent_ = 0, crossing_ = 0;
};

}  // namespace

bool is_shot_name(const std::string& name) {
  constexpr std::array<std::string_view, 5> kEndings{".usd", ".usda", ".usdc", ".usdz", ".abc"};
  std::string ending = std::filesystem::path(name).extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::find(kEndings, ending) != kEndings.end();
}

Scene load_shot(const std::filesystem::path& handover, const std::string& name, const std::string& ending,
                const SceneWarning& warn) {
  try {
    RecordFile file(handover);
    return ShotLoader(name, warn).load(file, ending);
  } catch (const shots::BadRecord& problem) {
    fail(name,
         ending.empty() ? fmt::format("cannot be read: its reader handed over {}", problem.what()) : ending);
  } catch (const InputFileError& problem) {
    fail(name, fmt::format("was read, but what was handed over {}", problem.what()));
  } catch (const std::bad_alloc&) {
    fail(name, "needs more memory than there is");
  }
}

}  // namespace stbvh::harness
