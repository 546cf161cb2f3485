/// The catalogue of hard cases: families of scenes and rays that are known to break ray tracers.
///
/// A case is a scene and rays through it, and what must come out: by default what the oracle says. A family
/// is one or more cases under one name: a row of the table of `stbvh-ab hard`, and a test of
/// hard_cases_test. The same count and seed make the same cases on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/scenes/scene.h"
#include "stbvh/structure.h"

namespace stbvh::harness {

/// What must come out where the oracle is not asked alone.
enum class Expected {
  kOracle,   ///< what the oracle says
  kClosed,   ///< the same, and the rays start inside a closed mesh: every miss is a leak besides
  kNothing,  ///< every ray is invalid or has an empty range: any hit is a false one; no oracle
  kRefused   ///< the scene itself is: building it must end with an error; the one ray stands for that
};

struct TriangleId {
  std::uint32_t geom_id;
  std::uint32_t prim_id;
};

struct HardCase {
  Scene scene{};
  std::vector<Ray> rays{};
  Expected expected = Expected::kOracle;
  std::vector<TriangleId> leaving{};  ///< the triangle that each ray starts from; empty: from none
};

/// Which structures can be asked without ending the process.
enum class Askable {
  kAll,    ///< every ray is traceable (is_traceable)
  kOurs,   ///< not those whose tree is Embree's
  kDirect  ///< those that are called without Embree: it asserts on the rays before any callback
};

struct HardFamily {
  std::string name;         ///< in kebab case
  std::string description;  ///< one sentence
  Askable askable = Askable::kAll;
  bool is_large = false;  ///< millions of primitive segments: left out of ctest
  /// Cases with `count` rays in all (the last ones may have fewer).
  std::function<std::vector<HardCase>(std::size_t count, std::uint64_t seed)> make;

  /// Whether the structure of that name may be asked.
  bool admits(std::string_view structure) const;
};

/// A list of one.
inline std::vector<HardCase> one_case(HardCase only) {
  std::vector<HardCase> cases;
  cases.push_back(std::move(only));
  return cases;
}

/// All families, in the order in which tables print them.
std::span<const HardFamily> hard_families();

/// The family of that name, or null.
const HardFamily* find_hard_family(std::string_view name);

}  // namespace stbvh::harness
