/// The pieces of the static city. y points up, streets run along x and z; a crossing lies at the origin, the
/// city reaches from there towards -z.
#pragma once

#include <array>

#include "harness/scenes/procedural/shared/machine_parts.h"

namespace stbvh::harness {

inline constexpr double kBlockSide = 26;
inline constexpr double kStreetWidth = 10;
inline constexpr double kBlockPitch = kBlockSide + kStreetWidth;

/// Where the block of column `i`, row `j` begins: its corner of least x and greatest z.
inline Vec3 block_corner(int i, int j) {
  return {0.5 * kStreetWidth + kBlockPitch * i, 0, -0.5 * kStreetWidth - kBlockPitch * j};
}

enum class CityPaint {
  kWallA,
  kWallB,
  kWallC,
  kWallD,
  kRoof,
  kSlate,
  kGlass,
  kTrim,
  kDoor,
  kPavement,
  kStreet,
  kMarking,
  kGrass,
  kTrunk,
  kLeaves,
  kIron
};
inline constexpr std::size_t kCityPaintCount = 16;

enum class TrafficPaint {
  kCarRed,
  kCarBlue,
  kCarWhite,
  kCarGlass,
  kTyre,
  kHub,
  kSkin,
  kShirtA,
  kShirtB,
  kTrousers,
  kSign,
  kSignBand
};
inline constexpr std::size_t kTrafficPaintCount = 12;

class StaticCity {
 public:
  StaticCity();
  Part& operator[](CityPaint paint) { return parts_[static_cast<std::size_t>(paint)]; }
  const std::vector<Part>& all() const { return parts_; }

 private:
  std::vector<Part> parts_;
};

/// Cars move in 9 steps, people in 17, signs in 13.
class Traffic {
 public:
  Traffic();
  Part& operator[](TrafficPaint paint) { return parts_[static_cast<std::size_t>(paint)]; }
  const std::vector<Part>& all() const { return parts_; }

 private:
  std::vector<Part> parts_;
};

/// How much there is to a block, 0 to 1: leaves, windows, cars and people thin out in the smallest scenes.
double block_richness(double scale);

/// One block: houses round its edge, a courtyard, pavement with trees and lamps.
void add_block(StaticCity& city, int column, int row, double richness, Pcg32& random);
/// A house on the ground rectangle of `width` along x and `depth` along z, its front towards +z, put at
/// `pose`.
void add_house(StaticCity& city, const Rigid& pose, double width, double depth, double richness,
               Pcg32& random);
void add_city_tree(StaticCity& city, Vec3 foot, double height, double richness, Pcg32& random);

/// A car driving `travel` metres from `start` over the shutter, towards `heading` about y (0: +x), turning by
/// `bend` radians on the way.
void add_car(Traffic& traffic, Vec3 start, double heading, double travel, double bend, TrafficPaint paint);
/// A person who walks `travel` metres.
void add_walker(Traffic& traffic, Vec3 start, double heading, double travel, TrafficPaint shirt,
                Pcg32& random);
/// A sign on a pole that turns about it.
void add_turning_sign(Traffic& traffic, Vec3 foot, double height, double radians);

}  // namespace stbvh::harness
