// The paper's barbershop: 1.4M triangles with 3 steps, 2.8M with 5, 3.9M with 9.
#include <iterator>

#include "harness/scenes/procedural/barbershop/shop_pieces.h"
#include "harness/scenes/procedural/scene_makers.h"

namespace stbvh::harness {
namespace {

constexpr double kHairShare =
    0.3;  // of the triangles with 9 steps; the smallest scenes thin out in hair first

void add_people(Barbershop& shop, double scale, std::uint64_t seed) {
  const auto hairs = [&](double share) {
    return scaled_count(3.9e6 * kHairShare * share / static_cast<double>(kStrandTriangles), scale);
  };
  const Chair left{{-2.3, 0, 0.1}, 0.35, 0.10};
  const Chair middle{{-0.1, 0, 0.0}, 0.15, -0.12};
  const Chair right{{2.0, 0, 0.3}, -1.1, 1.15};  // nobody sits in it: it spins
  for (const Chair& chair : {left, middle, right}) add_chair(shop, chair);
  add_customer(shop, left, ShopPaint::kFairHair, hairs(0.35), seed);
  add_customer(shop, middle, ShopPaint::kDarkHair, hairs(0.35), seed + 1);
  const Vec3 head = middle.place + Vec3{0, 1.62, 0};
  add_barber(shop, middle.place + Vec3{0.72, 0, -0.42}, head, hairs(0.2), seed + 2);
  add_clippings(shop, head, hairs(0.1), seed);
}

}  // namespace

ShopParts::ShopParts(std::size_t steps) {
  struct Color {
    const char* name;
    Vec3 color;
  };
  constexpr std::array<Color, kShopPaintCount> kColors{{{"white", {0.75, 0.74, 0.70}},
                                                        {"black", {0.03, 0.03, 0.032}},
                                                        {"walls", {0.46, 0.60, 0.54}},
                                                        {"wood", {0.27, 0.12, 0.05}},
                                                        {"mirrors", {0.50, 0.62, 0.72}},
                                                        {"chrome", {0.52, 0.54, 0.57}},
                                                        {"leather", {0.42, 0.03, 0.03}},
                                                        {"red", {0.65, 0.03, 0.04}},
                                                        {"blue", {0.04, 0.10, 0.45}},
                                                        {"green glass", {0.05, 0.30, 0.16}},
                                                        {"amber glass", {0.55, 0.26, 0.04}},
                                                        {"skin", {0.60, 0.37, 0.26}},
                                                        {"coat", {0.72, 0.73, 0.76}},
                                                        {"cape", {0.10, 0.26, 0.50}},
                                                        {"trousers", {0.07, 0.07, 0.10}},
                                                        {"dark hair", {0.05, 0.03, 0.02}},
                                                        {"fair hair", {0.48, 0.28, 0.08}},
                                                        {"towels", {0.80, 0.78, 0.72}},
                                                        {"brass", {0.72, 0.48, 0.14}}}};
  for (const Color& color : kColors) parts_.push_back({color.name, steps, color.color, {}, {}});
}

Motion on_dolly(Motion own) {
  return compose(rigid_motion([](double time) {
                   return translation(Vec3{-0.012, 0.002, 0.008} * time);
                 }),
                 std::move(own));
}

Patches cushion(Vec3 center, Vec3 half) {
  const auto flat = [](double x) { return std::copysign(std::pow(std::abs(x), 0.4), x); };
  return {{[=](double u, double v) {
             const double turn = 2 * kPi * u;
             const double rise = kPi * (0.004 + 0.992 * v);
             const double wide = flat(std::sin(rise));
             return center + Vec3{half.x * wide * flat(std::cos(turn)), -half.y * flat(std::cos(rise)),
                                  -half.z * wide * flat(std::sin(turn))};
           },
           4 * (half.x + half.z), 2 * half.y + half.x + half.z, 12, 8, Wrap::kU}};
}

Scene make_barbershop(double scale, std::uint64_t seed) {
  Barbershop shop;
  add_room(shop, seed);
  add_lamps_and_fan(shop);
  add_people(shop, scale, seed);
  add_pole(shop, {3.15, 0, -1.25});
  add_towels(shop);

  Scene scene;
  scene.name = "barbershop";
  const auto add = [&](const ShopParts& parts, double triangles) {
    std::vector<Mesh> meshes = tessellate(parts.all(), scaled_count(triangles, scale));
    scene.meshes.insert(scene.meshes.end(), std::make_move_iterator(meshes.begin()),
                        std::make_move_iterator(meshes.end()));
  };
  add(shop.furniture, 1.4e6);
  add(shop.turning, 2.8e6);
  add(shop.flowing, 3.9e6);
  scene.camera = {{0.8f, 1.95f, 6.2f}, {0.25f, 1.32f, 0.0f}, {0, 1, 0}, 41.0f};
  return scene;
}

}  // namespace stbvh::harness
