// A city of which 90 % stands still, with traffic of 9 to 17 steps: about 600k triangles at scale 1.
#include <algorithm>
#include <iterator>

#include "harness/scenes/procedural/city/city_pieces.h"
#include "harness/scenes/procedural/scene_makers.h"

namespace stbvh::harness {
namespace {

/// Streets and the meadow that the camera stands over.
void add_ground(StaticCity& city, int first_column, int columns, int rows) {
  const double x0 = kBlockPitch * first_column - 30, x1 = kBlockPitch * (first_column + columns) + 30;
  const double z0 = -kBlockPitch * rows - 30, z1 = 0.5 * kStreetWidth;
  const Placement coarse{{}, {}, 0.3};
  city[CityPaint::kStreet].add(quad({x0, 0, z1}, {x1, 0, z1}, {x1, 0, z0}, {x0, 0, z0}), coarse);
  city[CityPaint::kPavement].add(box({0.5 * (x0 + x1), 0.07, z1 + 1.2}, {0.5 * (x1 - x0), 0.08, 1.2}),
                                 {{}, {}, 0.5});
  city[CityPaint::kGrass].add(sheet(
                                  [=](double u, double v) {
                                    const double x = lerp(x0, x1, u), z = z1 + 2.4 + 34 * v;
                                    return Vec3{x, 0.1 + 0.12 * std::sin(0.8 * x) * std::sin(0.7 * z), z};
                                  },
                                  x1 - x0, 34, 12, 6),
                              coarse);
  const auto dash = [&](double x, double z, double hx, double hz) {
    city[CityPaint::kMarking].add(
        quad({x - hx, 0.02, z + hz}, {x + hx, 0.02, z + hz}, {x + hx, 0.02, z - hz}, {x - hx, 0.02, z - hz}));
  };
  for (int i = first_column; i <= first_column + columns; ++i) {
    const double x = kBlockPitch * i;
    for (double z = -7; z > z0; z -= 4) dash(x, z, 0.1, 1.0);
    for (int bar = -4; bar <= 4; ++bar) dash(x + bar, -5.9, 0.28, 0.9);  // zebra crossing
  }
  for (int j = 0; j <= rows; ++j) {
    for (double x = x0; x < x1; x += 4) dash(x, -kBlockPitch * j, 1.0, 0.1);
  }
}

void add_traffic(Traffic& traffic, int first_column, int columns, int rows, double richness, Pcg32& random) {
  constexpr std::array<TrafficPaint, 3> kCars{TrafficPaint::kCarRed, TrafficPaint::kCarBlue,
                                              TrafficPaint::kCarWhite};
  constexpr double kLane = 2.3;
  for (int j = 0; j < rows; ++j) {
    for (int i = first_column; i < first_column + columns; ++i) {
      const double x = kBlockPitch * i, z = -kBlockPitch * j;
      const auto paint = [&] { return kCars[random.next() % kCars.size()]; };
      // Lanes take turns, so that each street has traffic both ways. Random numbers are drawn one statement
      // each: the order in which arguments are worked out is the compiler's.
      const bool forth = (i + j) % 2 == 0;
      const double along = random.uniform(10, 18), fast = random.uniform(0.6, 1.3);
      const Vec3 start = forth ? Vec3{x + along, 0, z + kLane} : Vec3{x + along + 11, 0, z - kLane};
      add_car(traffic, start, forth ? 0 : kPi, fast, 0, paint());
      if (richness > 0.5) {
        const double down = random.uniform(9, 26), slow = random.uniform(0.5, 1.1);
        add_car(traffic, {x + (forth ? -kLane : kLane), 0, z - down}, forth ? -kPi / 2 : kPi / 2, slow, 0,
                paint());
      }
      const int walkers = std::max(1, static_cast<int>(std::lround(3 * richness)));
      for (int k = 0; k < walkers; ++k) {
        const bool along_x = k < 2;
        const Vec3 at = along_x ? Vec3{x + random.uniform(8, 28), 0.15, z - random.uniform(5.5, 6.2)}
                                : Vec3{x + random.uniform(5.6, 6.6), 0.15, z - random.uniform(7, 30)};
        const double heading = (along_x ? 0 : kPi / 2) + (random.uniform() < 0.5 ? kPi : 0);
        add_walker(traffic, at, heading, random.uniform(0.3, 0.6),
                   k % 2 == 0 ? TrafficPaint::kShirtA : TrafficPaint::kShirtB, random);
      }
      const double height = random.uniform(3.6, 5.0), turn = random.uniform(0.4, 1.2);
      add_turning_sign(traffic, {x + 5.8, 0.15, z - 5.9}, height, turn);
    }
  }
  if (richness > 0.5)
    add_car(traffic, {-1.5, 0, 1.6}, 0.35, 1.4, 0.5, TrafficPaint::kCarRed);  // turning at the crossing
}

}  // namespace

Scene make_static_city(double scale, std::uint64_t seed) {
  // The city grows with the scale: details keep their size.
  const int columns = std::clamp(static_cast<int>(4 * std::sqrt(scale) + 1e-6), 1, 40);
  const int rows = columns;
  const int first_column = -(columns / 2);
  const double richness = block_richness(scale);
  Pcg32 random(seed, 31);
  StaticCity city;
  Traffic traffic;
  add_ground(city, first_column, columns, rows);
  for (int j = 0; j < rows; ++j) {
    for (int i = first_column; i < first_column + columns; ++i) add_block(city, i, j, richness, random);
  }
  add_traffic(traffic, first_column, columns, rows, richness, random);

  Scene scene;
  scene.name = "static-city";
  scene.meshes = tessellate(city.all(), scaled_count(540e3, scale));
  std::vector<Mesh> moving = tessellate(traffic.all(), scaled_count(60e3, scale));
  scene.meshes.insert(scene.meshes.end(), std::make_move_iterator(moving.begin()),
                      std::make_move_iterator(moving.end()));
  scene.camera = {{4.0f, 7.5f, 19.0f}, {-0.8f, 2.6f, -8.0f}, {0, 1, 0}, 46.0f};
  return scene;
}

}  // namespace stbvh::harness
