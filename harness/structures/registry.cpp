#include <array>
#include <stdexcept>

#include "harness/structures/embree_structure.h"
#include "harness/structures/lbvh.h"
#include "harness/structures/stbvh_direct.h"
#include "harness/structures/stbvh_plugin.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

using StructurePtr = std::unique_ptr<StructureUnderTest>;

template <RTCSceneFlags kFlags>
StructurePtr build_embree(const Scene& scene, unsigned threads) {
  return std::make_unique<EmbreeStructure>(scene, "", kFlags, threads);
}

struct Entry {
  std::string_view name;
  StructurePtr (*build)(const Scene& scene, unsigned threads);
};

constexpr std::array<Entry, 8> kEntries{{
    {"embree", build_embree<RTC_SCENE_FLAG_NONE>},
    {"embree-robust", build_embree<RTC_SCENE_FLAG_ROBUST>},
    {"embree-compact", build_embree<RTC_SCENE_FLAG_COMPACT>},
    {"embree-4v",
     [](const Scene& scene, unsigned threads) -> StructurePtr {
       return std::make_unique<EmbreeStructure>(scene, kVertexLeaves, RTC_SCENE_FLAG_NONE, threads);
     }},
    {"lbvh",
     [](const Scene& scene, unsigned threads) -> StructurePtr {
       return std::make_unique<Lbvh>(scene, "", threads);
     }},
    {"lbvh-4v",
     [](const Scene& scene, unsigned threads) -> StructurePtr {
       return std::make_unique<Lbvh>(scene, kVertexLeaves, threads);
     }},
    {"stbvh",
     [](const Scene& scene, unsigned threads) -> StructurePtr {
       return std::make_unique<StbvhPlugin>(scene, threads);
     }},
    {"stbvh-direct",
     [](const Scene& scene, unsigned threads) -> StructurePtr {
       return std::make_unique<StbvhDirect>(scene, threads);
     }},
}};

}  // namespace

std::vector<std::string_view> structure_names() {
  std::vector<std::string_view> names;
  for (const Entry& entry : kEntries) names.push_back(entry.name);
  return names;
}

std::unique_ptr<StructureUnderTest> build_structure(std::string_view name, const Scene& scene,
                                                    unsigned threads) {
  for (const Entry& entry : kEntries) {
    if (entry.name == name) return entry.build(scene, threads);
  }
  throw std::invalid_argument("There is no structure \"" + std::string(name) + "\".");
}

}  // namespace stbvh::harness
