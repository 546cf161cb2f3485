#include <array>

#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/procedural/scene_makers.h"

namespace stbvh::harness {
namespace {

constexpr std::array<ProceduralScene, 10> kScenes{{
    {"llama", "a walking llama: fur of 3 steps, hide and short coat of 9", 0.06, make_llama},
    {"barbershop", "a barber's shop at work: 3, 5 and 9 steps", 0.06, make_barbershop},
    {"train", "a steam train: wheels and rods of 17 steps, the land of 3", 0.15, make_train},
    {"crowd", "people walking in a street: 2, 6 and 15 steps", 0.05, make_crowd},
    {"barbarian", "a figure swinging a sword, 15 steps", 1.0, make_barbarian},
    {"barbarian-rotate", "the same figure turning half a turn, 9 steps", 1.0, make_barbarian_rotate,
     make_barbarian_rotate_with_steps},
    {"cloth", "a cloth over a ball in a gust, 9 steps", 0.5, make_cloth, make_cloth_with_steps},
    {"wheels", "spinning wheels", 1.0, make_wheels},
    {"dancer", "a dancer in a pirouette with a flying skirt, 15 steps", 1.0, make_dancer},
    {"static-city", "a city that stands still, some traffic in it", 1.0, make_static_city},
}};
constexpr std::size_t kPaperScenes = 6;

}  // namespace

std::span<const ProceduralScene> procedural_scenes() {
  return kScenes;
}

std::span<const ProceduralScene> paper_scenes() {
  return procedural_scenes().first(kPaperScenes);
}

const ProceduralScene* find_procedural_scene(std::string_view name) {
  for (const ProceduralScene& scene : kScenes) {
    if (scene.name == name) return &scene;
  }
  return nullptr;
}

}  // namespace stbvh::harness
