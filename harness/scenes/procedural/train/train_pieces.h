/// The pieces of the train scene. x points forward, y up from the top of the rails, z to the side of the
/// camera. The camera follows the train: wheels turn and carriages sway while the landscape goes by.
#pragma once

#include <array>

#include "harness/scenes/procedural/shared/machine_parts.h"
#include "harness/scenes/procedural/shared/spoked_wheel.h"

namespace stbvh::harness {

enum class Paint { kBlack, kGreen, kRed, kBrass, kSteel, kCoal, kSteam, kMaroon, kCream, kGlass, kRoof };
inline constexpr std::size_t kPaintCount = 11;

/// What moves with the train: one part for each colour.
class TrainParts {
 public:
  explicit TrainParts(std::size_t steps);
  Part& operator[](Paint paint) { return parts_[static_cast<std::size_t>(paint)]; }
  const std::vector<Part>& all() const { return parts_; }

 private:
  std::vector<Part> parts_;
};

/// Metres travelled within the shutter: the driving wheels turn by 75 degrees.
inline constexpr double kTravel = 1.25;
inline constexpr double kDriverRadius = 0.95;
inline constexpr double kHalfGauge = 0.75;

/// How much there is to see, 0 to 1: trees and coal thin out in the smallest scenes.
double train_richness(double scale);

/// Rolling and bobbing of a vehicle on its springs, each with a phase of its own.
Motion sway(double phase);

/// A pair of wheels and their axle at `x`, painted `spokes`; `angle` turns the spokes at rest.
void add_axle(TrainParts& train, double x, const SpokedWheel& wheel, Paint spokes, double angle);

/// Engine, from the cowcatcher at x = 7.4 to the cab's end at x = -5.8, with its steam.
void add_locomotive(TrainParts& train, std::uint64_t seed);
/// Connecting and coupling rods, crossheads and cylinders of both sides.
void add_rods(TrainParts& train);
void add_steam(TrainParts& train, std::uint64_t seed);
/// Tender with coal, from x = -6.2 to -11.4.
void add_tender(TrainParts& train, double richness, std::uint64_t seed);
/// Carriage of 16 m centred at `x`.
void add_carriage(TrainParts& train, double x, double phase);

/// Track, meadow, trees and telegraph poles, going by.
std::vector<Part> make_landscape(std::size_t steps, double richness, std::uint64_t seed);

}  // namespace stbvh::harness
