/// cut_polygon(): polygons are covered once, whatever their shape.
#include "harness/scenes/obj/polygon_cutter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "harness/scenes/pcg32.h"

namespace stbvh::harness {
namespace {

using Corners = std::vector<Vec3>;

/// Twice its area, along its normal.
Vec3 area_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  return cross(b - a, c - a);
}

/// Of a flat polygon.
Vec3 area_of(const Corners& polygon) {
  Vec3 sum{};
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sum = sum + area_of(polygon[0], polygon[i - 1], polygon[i]);
  return sum;
}

/// As long as the polygon lies in a plane: triangles wound as it is, as large together as it is.
void expect_covered_once(const Corners& polygon, const std::string& what) {
  std::vector<std::uint32_t> triangles;
  const PolygonFlaws flaws = cut_polygon(polygon, triangles);
  EXPECT_FALSE(flaws.is_bent) << what;
  EXPECT_FALSE(flaws.crosses_itself) << what;
  ASSERT_EQ(triangles.size(), 3 * (polygon.size() - 2)) << what;
  const Vec3 normal = normalize(area_of(polygon));
  const double whole = length(area_of(polygon));
  double sum = 0;
  std::size_t inverted = 0;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const double part =
        dot(normal, area_of(polygon[triangles[i]], polygon[triangles[i + 1]], polygon[triangles[i + 2]]));
    inverted += part < -1e-12 * whole ? 1u : 0u;
    sum += std::abs(part);
  }
  EXPECT_EQ(inverted, 0u) << what;
  EXPECT_NEAR(sum, whole, 1e-9 * whole) << what;
}

/// In all three planes, both ways round, from each of some corners on.
void expect_always_covered_once(const Corners& polygon, const std::string& what) {
  for (int turn = 0; turn < 6; ++turn) {
    Corners turned;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 p = polygon[(i + static_cast<std::size_t>(turn) * polygon.size() / 6) % polygon.size()];
      turned.push_back(turn % 3 == 0 ? p : turn % 3 == 1 ? Vec3{p.y, p.z, p.x} : Vec3{p.z, p.x, p.y});
    }
    if (turn % 2 == 1) turned = Corners(turned.rbegin(), turned.rend());
    expect_covered_once(turned, what + ", turn " + std::to_string(turn));
  }
}

Corners around(std::size_t count, const std::function<double(std::size_t)>& radius, double turns = 1) {
  Corners corners;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2 * kPi * turns * static_cast<double>(i) / static_cast<double>(count);
    const double r = radius(i);
    corners.push_back({r * std::cos(angle), r * std::sin(angle), 0});
  }
  return corners;
}

TEST(PolygonCutter, Shapes) {
  expect_always_covered_once({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, "an L");
  expect_always_covered_once({{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}}, "an arrow");
  expect_always_covered_once({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}},
                             "corners on edges");
  expect_always_covered_once(around(5, [](std::size_t) { return 1; }), "a pentagon");
  for (const std::size_t count : {10u, 101u, 5000u}) {
    expect_always_covered_once(around(count, [](std::size_t i) { return i % 2 == 0 ? 1 : 0.2; }), "a star");
    const double n = static_cast<double>(count);
    Corners spiral = around(
        count, [&](std::size_t i) { return 0.5 + static_cast<double>(i) / n; }, 5);
    const Corners inner = around(
        count, [&](std::size_t i) { return 0.45 + static_cast<double>(i) / n; }, 5);
    spiral.insert(spiral.end(), inner.rbegin(), inner.rend());
    expect_always_covered_once(spiral, "a spiral");
  }
}

TEST(PolygonCutter, Combs) {
  for (const double slope : {0.0, 1.0}) {
    Corners comb{{0, 0, 0}, {2000, 0, 0}};
    for (int tooth = 2000; tooth > 0; --tooth) {
      comb.push_back({tooth - 0.25, 100, 0});
      if (tooth > 1) comb.push_back({tooth - 0.75, 1, 0});
    }
    for (Vec3& p : comb) p.x += slope * 20 * p.y;
    expect_always_covered_once(comb, "a comb");
  }
}

TEST(PolygonCutter, HolesThatAreJoinedToTheOutline) {
  expect_always_covered_once({{0, 0, 0},
                              {4, 0, 0},
                              {4, 4, 0},
                              {0, 4, 0},
                              {0, 0, 0},
                              {1, 1, 0},
                              {1, 3, 0},
                              {3, 3, 0},
                              {3, 1, 0},
                              {1, 1, 0}},
                             "a frame");
  Corners ring = around(100, [](std::size_t) { return 2; });
  const Corners inner = around(100, [](std::size_t i) { return i % 2 == 0 ? 1 : 1.5; });
  ring.push_back(ring.front());
  ring.push_back(inner.front());
  ring.insert(ring.end(), inner.rbegin(), inner.rend());
  expect_always_covered_once(ring, "a ring");
}

/// From each of its corners on.
void expect_covered_once_from_each(Corners polygon, const std::string& what) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    expect_always_covered_once(polygon, what + ", from " + std::to_string(i));
    std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
  }
}

TEST(PolygonCutter, OutlinesThatFoldBack) {
  const auto square = [](const Corners& on_top) {
    Corners corners{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}};
    corners.insert(corners.end(), on_top.begin(), on_top.end());
    corners.push_back({0, 4, 0});
    return corners;
  };
  expect_covered_once_from_each(square({{2, 4, 0}, {2, 6, 0}, {2, 4, 0}}), "a spur outwards");
  expect_covered_once_from_each(square({{2, 4, 0}, {2, 5, 0}, {2, 6, 0}, {2, 4.5, 0}, {2, 4, 0}}),
                                "a spur with other corners on its way back");
  expect_covered_once_from_each(square({{2, 4, 0},
                                        {2, 5, 0},
                                        {3, 5, 0},
                                        {2, 5, 0},
                                        {2, 6, 0},
                                        {2, 5, 0},
                                        {1, 6, 0},
                                        {2, 5, 0},
                                        {2, 4, 0}}),
                                "a spur with branches");
  expect_covered_once_from_each(square({{4, 6, 0}, {4, 4, 0}}), "a spur at a corner");
  expect_covered_once_from_each(square({{2, 4, 0}, {2, 2, 0}, {2, 4, 0}}), "a slit");
  expect_covered_once_from_each(square({{4, 4, 0}, {2, 3, 0}, {2, 3, 0}, {2, 3, 0}}),
                                "points that are repeated");
  Corners antenna;
  for (int i = 0; i < 20000; ++i) antenna.push_back({2, 4 + std::min(i, 19999 - i) / 64.0, 0});
  expect_always_covered_once(square(antenna), "a long spur");
}

TEST(PolygonCutter, OutlinesThatTouchTheirOwnEdges) {
  expect_covered_once_from_each({{1.5625, 3, 0},
                                 {3, 3, 0},
                                 {2, 6, 0},
                                 {0, 2, 0},
                                 {2, 3, 0},
                                 {1.5, 3, 0},
                                 {1, 3, 0},
                                 {2, 4.875, 0},
                                 {1.4375, 3, 0}},
                                "a hole that touches the edges that join it");
}

/// Triangles of `polygon` cover `other`, which has as many corners, once.
void expect_covered_once_as(const Corners& polygon, const Corners& other) {
  std::vector<std::uint32_t> triangles;
  cut_polygon(polygon, triangles);
  double sum = 0;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const double part = area_of(other[triangles[i]], other[triangles[i + 1]], other[triangles[i + 2]]).z;
    EXPECT_GE(part, 0) << i / 3;
    sum += part;
  }
  EXPECT_NEAR(sum, area_of(other).z, 1e-9);
}

TEST(PolygonCutter, SlitsMayOpen) {
  const auto square = [](double gap) {
    return Corners{{0, 0, 0}, {4, 0, 0},       {4, 4, 0},       {2 + gap, 4, 0}, {2 + gap, 3, 0},
                   {2, 2, 0}, {2 - gap, 3, 0}, {2 - gap, 4, 0}, {0, 4, 0}};
  };
  Corners closed = square(0), open = square(0.25);
  for (std::size_t i = 0; i < closed.size(); ++i) {
    expect_always_covered_once(closed, "a slit");
    expect_covered_once_as(closed, open);
    std::rotate(closed.begin(), closed.begin() + 1, closed.end());
    std::rotate(open.begin(), open.begin() + 1, open.end());
  }
}

TEST(PolygonCutter, CrowdedCorners) {
  const int count = 50000;
  Corners cluster{{0, 0, 0}, {1000, 0, 0}, {1000, 1000, 0}};
  for (int i = 0; i < count; ++i)
    cluster.push_back({i % 2 == 0 ? 1.0 : 2.0, 2 - static_cast<double>(i) / count, 0});
  expect_covered_once(cluster, "a zigzag in a corner");
  Corners comb{{0, 0, 0}, {1000, 0, 0}}, ribbon;
  for (double i = count / 2; i > 0; --i) {
    comb.push_back({(i - 0.25) * 2 / count, 1, 0});
    comb.push_back({(i - 0.75) * 2 / count, 0.01, 0});
  }
  expect_covered_once(comb, "a comb in a corner");
  for (double i = 0; i < count / 2; ++i) ribbon.push_back({i, i + 1e-9 * i * (count / 2 - i), 0});
  for (double i = count / 2; i > 0; --i) ribbon.push_back({i - 1.5, i - 0.4, 0});
  expect_covered_once(ribbon, "a slanting ribbon");
}

TEST(PolygonCutter, RandomStars) {
  Pcg32 random(1);
  for (std::size_t round = 0; round < 300; ++round) {
    const std::size_t count = 4 + round % 40;
    expect_always_covered_once(around(count, [&](std::size_t) { return random.uniform(0.05, 1); }),
                               "star " + std::to_string(round));
  }
}

PolygonFlaws flaws_of(const Corners& polygon) {
  std::vector<std::uint32_t> triangles;
  const PolygonFlaws flaws = cut_polygon(polygon, triangles);
  EXPECT_EQ(triangles.size(), 3 * (polygon.size() - 2));
  for (const std::uint32_t corner : triangles) EXPECT_LT(corner, polygon.size());
  return flaws;
}

TEST(PolygonCutter, PolygonsThatCrossThemselves) {
  EXPECT_TRUE(flaws_of({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).crosses_itself);
  EXPECT_TRUE(flaws_of(around(
                           5, [](std::size_t) { return 1; }, 2))
                  .crosses_itself);  // a pentagram
  EXPECT_TRUE(flaws_of(around(
                           999, [](std::size_t) { return 1; }, 2))
                  .crosses_itself);
  Pcg32 random(2);
  Corners tangle;
  for (int i = 0; i < 3000; ++i) tangle.push_back({random.uniform(), random.uniform(), 0});
  EXPECT_TRUE(flaws_of(tangle).crosses_itself);
}

TEST(PolygonCutter, PolygonsThatCrossAtTheirCorners) {
  const Vec3 a{0, 0, 0}, b{1, 1, 0}, c{2, 2, 0}, d{2, 0, 0}, e{0, 3, 0};
  EXPECT_TRUE(flaws_of({a, b, c, d, b, e}).crosses_itself);
  EXPECT_TRUE(flaws_of({{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {2, 0, 0}, {1.5, -2, 0}, {1, 0, 0}, {0, 2, 0}})
                  .crosses_itself);
  const Corners square{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  Corners twice = square;
  twice.insert(twice.end(), square.begin(), square.end());
  EXPECT_TRUE(flaws_of(twice).crosses_itself);
  EXPECT_FALSE(flaws_of({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}}).crosses_itself);  // touches
  // The notch's tip is beyond the edge from (100, 100) to (104, 101), by the rounding of floats.
  EXPECT_FALSE(flaws_of({{104, 109, 0},
                         {101.5, 109, 0},
                         {100.829964f, 100.207489f, 0},
                         {100.5, 109, 0},
                         {100, 109, 0},
                         {100, 100, 0},
                         {104, 101, 0}})
                   .crosses_itself);
}

TEST(PolygonCutter, CornersThatAreNotFinite) {
  const Corners concave{{2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}, {0, 0.5, 0}, {0, 0, 0}};
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    for (std::uint32_t i = 0; i < concave.size(); ++i) {
      Corners corners = concave;
      corners[i].y = bad;
      std::vector<std::uint32_t> triangles;
      const PolygonFlaws flaws = cut_polygon(corners, triangles);
      EXPECT_FALSE(flaws.is_bent || flaws.crosses_itself);
      ASSERT_EQ(triangles.size(), 3 * (concave.size() - 2));
      for (std::size_t t = 0; t < triangles.size(); t += 3)
        EXPECT_EQ(std::count(&triangles[t], &triangles[t] + 3, i), 1)
            << "corner " << i << ", triangle " << t / 3;
    }
  }
}

TEST(PolygonCutter, PolygonsWithoutAPlane) {
  EXPECT_TRUE(flaws_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}}).is_bent);
  EXPECT_FALSE(flaws_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.001}, {0, 1, 0}}).is_bent);
  flaws_of(Corners(1000, Vec3{1, 2, 3}));
  Corners line;
  for (int i = 0; i < 1000; ++i) line.push_back({static_cast<double>(i % 7), 0, 0});
  flaws_of(line);
  flaws_of({{0, 0, 0}, {1, 0, 0}, {std::nan(""), 1, 0}, {0, 1, 0}, {0, HUGE_VAL, 0}});
  flaws_of({{3e38, 0, 0}, {0, 3e38, 0}, {-3e38, 0, 0}, {0, 1e38, 0}});
}

}  // namespace
}  // namespace stbvh::harness
