/// Closed moving meshes seen from inside.
#include <fmt/format.h>

#include "harness/hard_cases/aiming.h"
#include "harness/hard_cases/catalogue.h"

namespace stbvh::harness {
namespace {

constexpr std::size_t kSegments[] = {1, 2, 8, 16, 128};

HardFamily closed(std::string_view size, std::size_t cuts, std::size_t segments) {
  const Body body{.cuts = cuts, .segments = segments};
  return {.name = fmt::format("closed-{}-{}", size, segments),
          .description = fmt::format("From inside a closed body of {} triangles in {} segments at its "
                                     "vertices, its edges, and one ulp beside them.",
                                     size, segments),
          .is_large = 8 * cuts * cuts * segments > 1'000'000,
          .make = [body](std::size_t count, std::uint64_t seed) {
            Pcg32 random(seed, 1);
            return one_case(inside_body(body, count, random));
          }};
}

}  // namespace

void add_closed_families(std::vector<HardFamily>& families) {
  for (const std::size_t segments : kSegments) families.push_back(closed("2k", kCuts2k, segments));
  for (const std::size_t segments : kSegments) {
    families.push_back(closed("160k", kCuts160k, segments));
  }
}

}  // namespace stbvh::harness
