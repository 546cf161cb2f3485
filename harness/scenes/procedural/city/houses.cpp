// Blocks, houses and trees of the static city.
#include <algorithm>

#include "harness/scenes/procedural/city/city_pieces.h"

namespace stbvh::harness {
namespace {

/// Upright rectangle of a wall: `across` runs along it, `out` points away from the house.
struct Wall {
  Vec3 foot;  // at its middle
  Vec3 across, out;
  double width;
};

Patches wall_box(const Wall& wall, double x, double y, double half_x, double half_y, double depth) {
  const Vec3 center = wall.foot + wall.across * x + Vec3{0, y, 0} + wall.out * (0.5 * depth);
  const auto extent = [](double a, double b) { return std::abs(a) + std::abs(b); };
  return box(center, {extent(wall.across.x * half_x, wall.out.x * 0.5 * depth), half_y,
                      extent(wall.across.z * half_x, wall.out.z * 0.5 * depth)});
}

void add_windows(StaticCity& city, const Wall& wall, const Rigid& pose, double storey, int storeys, bool door,
                 double richness) {
  const Placement place{pose, {}, 1};
  const int count = std::max(1, static_cast<int>(std::lround(wall.width / 2.0 * std::sqrt(richness))));
  const double pitch = wall.width / count;
  for (int k = 0; k < storeys; ++k) {
    for (int i = 0; i < count; ++i) {
      const double x = -0.5 * wall.width + pitch * (i + 0.5);
      if (door && k == 0 && i == count / 2) {
        city[CityPaint::kDoor].add(wall_box(wall, x, 1.1, 0.5, 1.1, 0.06), place);
        city[CityPaint::kTrim].add(wall_box(wall, x, 2.28, 0.75, 0.07, 0.5), place);
        city[CityPaint::kTrim].add(wall_box(wall, x, 0.1, 0.7, 0.1, 0.6), place);
        continue;
      }
      const double y = storey * k + 1.75;
      city[CityPaint::kGlass].add(wall_box(wall, x, y, 0.42, 0.68, 0.03), place);
      city[CityPaint::kTrim].add(wall_box(wall, x, y - 0.74, 0.55, 0.06, 0.16), place);
      city[CityPaint::kTrim].add(wall_box(wall, x, y + 0.75, 0.5, 0.06, 0.09), place);
      city[CityPaint::kTrim].add(wall_box(wall, x, y, 0.03, 0.68, 0.06), place);
    }
  }
}

void add_gable_roof(StaticCity& city, const Rigid& pose, double width, double depth, double height,
                    double rise, CityPaint wall) {
  const double w = 0.5 * width + 0.3, d = 0.5 * depth + 0.4;
  const double eaves = height - rise * 0.4 / (0.5 * depth), ridge = height + rise;
  const Placement place{pose, {}, 1};
  for (const double side : {-1.0, 1.0}) {
    city[CityPaint::kRoof].add(
        quad({-w, eaves, side * d}, {w, eaves, side * d}, {w, ridge, 0}, {-w, ridge, 0}), place);
    const double x = side * 0.5 * width;
    city[wall].add(quad({x, height, -0.5 * depth}, {x, height, 0.5 * depth}, {x, ridge - 0.05, 0.01},
                        {x, ridge - 0.05, -0.01}),
                   place);
  }
  city[CityPaint::kWallD].add(box({0.3 * width, ridge, -0.12 * depth}, {0.35, 0.9, 0.35}), place);
}

void add_flat_roof(StaticCity& city, const Rigid& pose, double width, double depth, double height) {
  const Placement place{pose, {}, 1};
  const double w = 0.5 * width, d = 0.5 * depth;
  city[CityPaint::kSlate].add(quad({-w, height, d}, {w, height, d}, {w, height, -d}, {-w, height, -d}),
                              place);
  for (const double side : {-1.0, 1.0}) {
    city[CityPaint::kTrim].add(box({0, height + 0.2, side * d}, {w + 0.12, 0.32, 0.12}), place);
    city[CityPaint::kTrim].add(box({side * w, height + 0.2, 0}, {0.12, 0.32, d + 0.12}), place);
  }
  city[CityPaint::kSlate].add(box({-0.2 * width, height + 0.6, 0}, {0.9, 0.6, 0.9}), place);
  city[CityPaint::kIron].add(cylinder({0.2 * width, height, -0.2 * depth},
                                      {0.2 * width, height + 2.4, -0.2 * depth}, 0.04, 0.03, true, 5),
                             place);
}

void add_lamp(StaticCity& city, Vec3 foot) {
  city[CityPaint::kIron].add(cylinder(foot, foot + Vec3{0, 4.2, 0}, 0.08, 0.05, false, 6));
  city[CityPaint::kTrim].add(ellipsoid(foot + Vec3{0, 4.4, 0}, {0.22, 0.28, 0.22}, 8, 5));
  city[CityPaint::kIron].add(cylinder(foot + Vec3{0, 4.62, 0}, foot + Vec3{0, 4.8, 0}, 0.26, 0.04, true, 8));
}

}  // namespace

StaticCity::StaticCity() {
  struct Color {
    const char* name;
    Vec3 color;
  };
  constexpr std::array<Color, kCityPaintCount> kColors{{{"brick walls", {0.42, 0.14, 0.09}},
                                                        {"yellow walls", {0.66, 0.50, 0.24}},
                                                        {"white walls", {0.68, 0.66, 0.60}},
                                                        {"grey walls", {0.36, 0.35, 0.36}},
                                                        {"tiled roofs", {0.36, 0.09, 0.045}},
                                                        {"slate roofs", {0.16, 0.17, 0.20}},
                                                        {"window glass", {0.05, 0.08, 0.12}},
                                                        {"trim", {0.72, 0.70, 0.66}},
                                                        {"doors", {0.07, 0.16, 0.10}},
                                                        {"pavement", {0.42, 0.41, 0.39}},
                                                        {"street", {0.12, 0.12, 0.13}},
                                                        {"markings", {0.78, 0.78, 0.75}},
                                                        {"grass", {0.14, 0.26, 0.07}},
                                                        {"trunks", {0.16, 0.09, 0.05}},
                                                        {"leaves", {0.08, 0.20, 0.045}},
                                                        {"iron", {0.06, 0.07, 0.07}}}};
  for (const Color& color : kColors) parts_.push_back({color.name, 1, color.color, {}, {}});
}

double block_richness(double scale) {
  return std::clamp(scale / 0.06, 0.05, 1.0);
}

void add_house(StaticCity& city, const Rigid& pose, double width, double depth, double richness,
               Pcg32& random) {
  constexpr double kStorey = 3.0;
  constexpr std::array<CityPaint, 4> kWalls{CityPaint::kWallA, CityPaint::kWallB, CityPaint::kWallC,
                                            CityPaint::kWallD};
  const CityPaint paint = kWalls[random.next() % kWalls.size()];
  const bool gabled = random.uniform() < 0.6;
  const int storeys =
      gabled ? 2 + static_cast<int>(random.next() % 2) : 3 + static_cast<int>(random.next() % 4);
  const double height = kStorey * storeys + 0.4;
  const double w = 0.5 * width, d = 0.5 * depth;
  const std::array<Wall, 4> walls{{{{0, 0, d}, {1, 0, 0}, {0, 0, 1}, width},
                                   {{0, 0, -d}, {1, 0, 0}, {0, 0, -1}, width},
                                   {{w, 0, 0}, {0, 0, 1}, {1, 0, 0}, depth},
                                   {{-w, 0, 0}, {0, 0, 1}, {-1, 0, 0}, depth}}};
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const Wall& wall = walls[i];
    const Vec3 half = wall.across * (0.5 * wall.width), top{0, height, 0};
    city[paint].add(quad(wall.foot - half, wall.foot + half, wall.foot + half + top, wall.foot - half + top),
                    {pose, {}, 1});
    if (i < 2 || storeys > 4) add_windows(city, wall, pose, kStorey, storeys, i == 0, richness);
  }
  if (gabled) {
    add_gable_roof(city, pose, width, depth, height, random.uniform(1.8, 2.8), paint);
  } else {
    add_flat_roof(city, pose, width, depth, height);
  }
}

void add_city_tree(StaticCity& city, Vec3 foot, double height, double richness, Pcg32& random) {
  const Vec3 top = foot + Vec3{0, 0.7 * height, 0};
  city[CityPaint::kTrunk].add(cylinder(foot, top, 0.04 * height, 0.015 * height, false, 6));
  constexpr double kMostLeaves = 150;
  const int leaves = static_cast<int>(std::lround(kMostLeaves * richness));
  for (int i = 0; i < leaves; ++i) {  // leaves on a cloud of points about the top
    const double turn = random.uniform(0, 2 * kPi), rise = random.uniform(-1, 1);
    const double r = 0.30 * height * std::cbrt(random.uniform(0.3, 1));
    const double flat = std::sqrt(1 - rise * rise);
    const Vec3 out{flat * std::cos(turn), rise, flat * std::sin(turn)};
    const Vec3 at = top + Vec3{out.x * r, 1.1 * out.y * r, out.z * r};
    const double size = random.uniform(0.16, 0.34);
    const Vec3 axis = normalize(Vec3{random.uniform(-1, 1), 0.3, random.uniform(-1, 1)});
    const Rigid pose{axis_angle(axis, random.uniform(0, 6)), at};
    city[CityPaint::kLeaves].add({{[size](double u, double v) {
                                   return Vec3{size * (2 * u - 1), 0.3 * size * u * v, size * (2 * v - 1)};
                                 }}},
                                 {pose, {}, 1});
  }
}

void add_block(StaticCity& city, int column, int row, double richness, Pcg32& random) {
  const Vec3 corner = block_corner(column, row);
  const Vec3 middle = corner + Vec3{0.5 * kBlockSide, 0, -0.5 * kBlockSide};
  city[CityPaint::kPavement].add(box(middle + Vec3{0, 0.07, 0}, {0.5 * kBlockSide, 0.08, 0.5 * kBlockSide}),
                                 {{}, {}, 0.4});
  city[CityPaint::kGrass].add(box(middle + Vec3{0, 0.18, 0}, {5.0, 0.02, 5.0}), {{}, {}, 0.4});
  constexpr double kInset = 2.6, kDepth = 6.0;
  const double reach = 0.5 * kBlockSide - kInset - 0.5 * kDepth;
  for (int side = 0; side < 4; ++side) {  // houses in a ring, each row fills one corner
    const Rigid turn = translation(middle + Vec3{0, 0.15, 0}) * rotation({0, 1, 0}, 0.5 * kPi * side);
    const double length = kBlockSide - 2 * kInset - kDepth;
    double begin = -0.5 * length - 0.5 * kDepth;
    const int houses = 2;
    for (int i = 0; i < houses; ++i) {
      const double width = length / houses + (i == 0 ? random.uniform(-1.2, 1.2) : 0);
      const double used = i + 1 == houses ? 0.5 * length - 0.5 * kDepth - begin : width;
      add_house(city, turn * translation({begin + 0.5 * used, 0, reach}), used - 0.15, kDepth, richness,
                random);
      begin += used;
    }
    for (int i = 0; i < 3; ++i) {
      const Vec3 foot{-9.5 + 8.5 * i, 0, 0.5 * kBlockSide - 0.8};
      add_city_tree(city, turn.apply(foot), random.uniform(3.4, 5.2), richness, random);
    }
    add_lamp(city, turn.apply({7.0, 0, 0.5 * kBlockSide - 0.6}));
  }
}

}  // namespace stbvh::harness
