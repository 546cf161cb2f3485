/// The pieces of the barbershop. y points up from the floor, the camera looks towards -z; the room has no
/// front wall and no ceiling. The camera moves a little on its dolly, so that everything moves at least that
/// much.
#pragma once

#include <array>

#include "harness/scenes/procedural/shared/machine_parts.h"

namespace stbvh::harness {

enum class ShopPaint {
  kWhite,
  kBlack,
  kWall,
  kWood,
  kMirror,
  kChrome,
  kLeather,
  kRed,
  kBlue,
  kGreenGlass,
  kAmberGlass,
  kSkin,
  kCoat,
  kCape,
  kTrousers,
  kDarkHair,
  kFairHair,
  kTowel,
  kBrass
};
inline constexpr std::size_t kShopPaintCount = 19;

/// All parts with one number of steps.
class ShopParts {
 public:
  explicit ShopParts(std::size_t steps);
  Part& operator[](ShopPaint paint) { return parts_[static_cast<std::size_t>(paint)]; }
  const std::vector<Part>& all() const { return parts_; }

 private:
  std::vector<Part> parts_;
};

/// The whole shop: what only the dolly moves, what turns and swings, and what flows.
struct Barbershop {
  ShopParts furniture{3};
  ShopParts turning{5};
  ShopParts flowing{9};
};

/// `own` as seen from the camera on its dolly.
Motion on_dolly(Motion own = {});

/// Ellipsoid with flattened sides.
Patches cushion(Vec3 center, Vec3 half);

/// A barber's chair: at `place`, turned by `yaw` from +z, turning by `turn` over the shutter.
struct Chair {
  Vec3 place;
  double yaw = 0;
  double turn = 0;

  Rigid pose(double time) const { return translation(place) * rotation({0, 1, 0}, yaw + turn * time); }
};

/// Floor, walls, mirrors, counter with bottles, the shop's sign.
void add_room(Barbershop& shop, std::uint64_t seed);
void add_lamps_and_fan(Barbershop& shop);
void add_chair(Barbershop& shop, const Chair& chair);
/// A customer in the chair, under a cape, with `strands` hairs.
void add_customer(Barbershop& shop, const Chair& chair, ShopPaint hair, std::size_t strands,
                  std::uint64_t seed);
/// The barber, on his feet at `place` with his hands at `work`.
void add_barber(Barbershop& shop, Vec3 place, Vec3 work, std::size_t strands, std::uint64_t seed);
/// Hairs on a head of centre `head` in the frame of `body`.
void add_hair(Barbershop& shop, Vec3 head, const std::function<Rigid(double)>& body, ShopPaint paint,
              std::size_t strands, std::uint64_t seed);
/// Cut hair falling from about `from`.
void add_clippings(Barbershop& shop, Vec3 from, std::size_t strands, std::uint64_t seed);
void add_pole(Barbershop& shop, Vec3 foot);
void add_towels(Barbershop& shop);

/// Triangles of one hair.
inline constexpr std::size_t kStrandTriangles = 2 * 3 * 8;

}  // namespace stbvh::harness
