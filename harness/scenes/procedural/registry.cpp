#include <array>

#include "harness/scenes/procedural/procedural.h"
#include "harness/scenes/procedural/scene_makers.h"

namespace stbvh::harness {
namespace {

constexpr std::array<ProceduralScene, 13> kScenes{{
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
    {"torus", "small: a turning torus on a ground, 9 steps", 0.1, make_torus},
    {"walker", "small: one coarse figure walking, 9 steps", 1.0, make_walker},
    {"cart", "small: a cart on the road, 2 and 9 steps", 1.0, make_cart},
}};
constexpr std::size_t kPaperScenes = 6, kLargeScenes = 10;

}  // namespace

std::span<const ProceduralScene> procedural_scenes() {
  return kScenes;
}

std::span<const ProceduralScene> scene_group(std::string_view name) {
  const std::span<const ProceduralScene> all = procedural_scenes();
  if (name == "paper") return all.first(kPaperScenes);
  if (name == "large") return all.first(kLargeScenes);
  if (name == "small") return all.subspan(kLargeScenes);
  return name == "all" ? all : all.first(0);
}

const ProceduralScene* find_procedural_scene(std::string_view name) {
  for (const ProceduralScene& scene : kScenes) {
    if (scene.name == name) return &scene;
  }
  return nullptr;
}

}  // namespace stbvh::harness
