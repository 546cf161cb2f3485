#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "harness/structures/embree_device.h"
#include "harness/structures/embree_structure.h"
#include "harness/structures/gallery/gallery.h"
#include "harness/structures/lbvh.h"
#include "harness/structures/stbvh_direct.h"
#include "harness/structures/stbvh_plugin.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

using StructurePtr = std::unique_ptr<StructureUnderTest>;

template <RTCSceneFlags kFlags>
StructurePtr build_embree(const Scene& scene, unsigned threads, const BuildProgress& progress) {
  return std::make_unique<EmbreeStructure>(scene, "", kFlags, threads, progress);
}

struct Entry {
  std::string_view name;
  std::string_view description;
  StructurePtr (*build)(const Scene& scene, unsigned threads, const BuildProgress& progress);
};

constexpr std::array<Entry, 16> kEntries{{
    {"embree", "Embree's own motion blur tree, as an application gets it by default",
     build_embree<RTC_SCENE_FLAG_NONE>},
    {"embree-robust", "the same with the flag ROBUST", build_embree<RTC_SCENE_FLAG_ROBUST>},
    {"embree-compact", "the same with the flag COMPACT", build_embree<RTC_SCENE_FLAG_COMPACT>},
    {"embree-4v", "the same with the vertices in its leaves (bvh8.triangle4vmb)",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<EmbreeStructure>(scene, kVertexLeaves, RTC_SCENE_FLAG_NONE, threads, progress);
     }},
    {"embree-16", "Embree's own motion blur tree, asked by rtcIntersect16 and rtcOccluded16",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<InPackets<EmbreeStructure>>(scene, "", RTC_SCENE_FLAG_NONE, threads, progress);
     }},
    {"lbvh", "a tree of linear motion for each time segment, made of Embree's",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<Lbvh>(scene, "", threads, progress);
     }},
    {"lbvh-4v", "the same with the vertices in its leaves",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<Lbvh>(scene, kVertexLeaves, threads, progress);
     }},
    {"stbvh", "our plugin, as an application attaches it to Embree",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhPlugin>(scene, PluginSettings{}, threads, progress);
     }},
    {"stbvh-16", "the same, asked by rtcIntersect16 and rtcOccluded16",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<InPackets<StbvhPlugin>>(scene, PluginSettings{}, threads, progress);
     }},
    {"stbvh-beside", "our plugin for what moves, Embree's own triangles for what stands still, in one scene",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhPlugin>(scene, PluginSettings{.still_in_embree = true}, threads,
                                            progress);
     }},
    {"stbvh-fast", "our plugin with the precision FAST: not watertight",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhPlugin>(scene, PluginSettings{.precision = STBVH_PRECISION_FAST}, threads,
                                            progress);
     }},
    {"stbvh-direct", "our kernels without Embree, as stbvhIntersect1 asks them",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhDirect>(scene, BuildSettings{}, threads, progress);
     }},
    {"stbvh-batch", "our kernels without Embree, many rays in a call, as stbvhIntersectN asks them",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhBatch>(scene, BuildSettings{}, threads, progress);
     }},
    {"stbvh-direct-fast", "our kernels without Embree, not watertight",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhDirect>(scene, BuildSettings{.precision = Precision::kFast}, threads,
                                            progress);
     }},
    {"stbvh-direct-indexed",
     "our kernels without Embree, in as few bytes as possible: all leaves read the buffers",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhDirect>(scene, BuildSettings{.max_bytes = kSmallest}, threads, progress);
     }},
    {"stbvh-direct-scalar", "our kernels without Embree and without vector instructions",
     [](const Scene& scene, unsigned threads, const BuildProgress& progress) -> StructurePtr {
       return std::make_unique<StbvhDirect>(scene, BuildSettings{}, threads, progress, Isa::kScalar);
     }},
}};

/// The same defect in both majors, of which only Debian's Embree 3.13 has the assertions.
constexpr const char* kWhyNotOverUnlikeRanges =
    RTC_VERSION_MAJOR >= 4
        ? "Embree 4 fails to build these leaves over unlike time ranges, or loses triangles"
        : "Embree 3.13 aborts the process while it builds these leaves over unlike time ranges";

/// Which have eight children a node.
bool has_trees_of_vertex_leaves() {
  static const bool has =
      rtcGetDeviceProperty(EmbreeDevice("", 1).get(), RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0;
  return has;
}

/// Why Embree's own geometries cannot hold the motion of `mesh`; empty if they can.
std::string why_not_in_embree(const Mesh& mesh) {
  if (mesh.is_static() || mesh.triangle_count() == 0) return "";
  const bool is_too_many = mesh.steps.size() > kMaxSceneSteps;
  if (!is_too_many && !mesh.has_step_times()) return "";
  return fmt::format("Embree takes equidistant steps, {} at most, and \"{}\" has {}{}", kMaxSceneSteps,
                     mesh.name, mesh.steps.size(), mesh.has_step_times() ? " at times of their own" : "");
}

const gallery::GalleryEntry* find_in_gallery(std::string_view name) {
  const auto entries = gallery::gallery_entries();
  const auto found = std::ranges::find(entries, name, &gallery::GalleryEntry::name);
  return found == entries.end() ? nullptr : &*found;
}

std::invalid_argument unknown_structure(std::string_view name) {
  return std::invalid_argument("There is no structure \"" + std::string(name) + "\".");
}

}  // namespace

std::vector<std::string_view> structure_names() {
  std::vector<std::string_view> names;
  for (const Entry& entry : kEntries) names.push_back(entry.name);
  return names;
}

std::vector<std::string_view> gallery_names() {
  std::vector<std::string_view> names;
  for (const gallery::GalleryEntry& entry : gallery::gallery_entries()) names.push_back(entry.name);
  return names;
}

bool is_in_gallery(std::string_view name) {
  return find_in_gallery(name) != nullptr;
}

std::string_view structure_description(std::string_view name) {
  for (const Entry& entry : kEntries) {
    if (entry.name == name) return entry.description;
  }
  if (const auto* entry = find_in_gallery(name)) return entry->description;
  throw unknown_structure(name);
}

bool is_updatable(std::string_view name) {
  constexpr std::array<std::string_view, 3> kOurs{"stbvh", "stbvh-16", "stbvh-fast"};
  return name.starts_with("embree") || std::ranges::find(kOurs, name) != kOurs.end();
}

std::string obstacle(std::string_view name, const Scene& scene) {
  if (const auto* entry = find_in_gallery(name)) return entry->obstacle ? entry->obstacle(scene) : "";
  if (!name.starts_with("stbvh")) {
    for (const Mesh& mesh : scene.meshes) {
      if (std::string why = why_not_in_embree(mesh); !why.empty()) return why;
    }
  }
  if (!name.ends_with("-4v")) return "";
  const Mesh* first = nullptr;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.is_static()) continue;
    if (first == nullptr) first = &mesh;
    if (mesh.time_range.begin != first->time_range.begin || mesh.time_range.end != first->time_range.end)
      return kWhyNotOverUnlikeRanges;
  }
  if (first != nullptr && !has_trees_of_vertex_leaves()) return "Embree has these leaves from AVX on";
  return "";
}

bool is_limitable(std::string_view name) {
  return name.starts_with("stbvh") && !is_in_gallery(name);
}

bool is_scalar(std::string_view name) {
  const auto* entry = find_in_gallery(name);
  return entry != nullptr ? entry->is_scalar : name.ends_with("-scalar");
}

bool is_exact(std::string_view name) {
  if (const auto* entry = find_in_gallery(name)) return entry->is_exact;
  return name.starts_with("stbvh") && !name.ends_with("-fast") && name != "stbvh-beside";
}

std::unique_ptr<StructureUnderTest> build_structure(std::string_view name, const Scene& scene,
                                                    unsigned threads, const BuildProgress& progress) {
  if (const std::string why = obstacle(name, scene); !why.empty())
    throw std::runtime_error(std::string(name) + ": " + why + ".");
  for (const Entry& entry : kEntries) {
    if (entry.name == name) return entry.build(scene, threads, progress);
  }
  if (const auto* entry = find_in_gallery(name)) return entry->build(scene, threads, progress);
  throw unknown_structure(name);
}

}  // namespace stbvh::harness
