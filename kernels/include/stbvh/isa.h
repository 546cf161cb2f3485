/// Instruction sets of the traversal, chosen at run time.
#pragma once

#include <string_view>
#include <vector>

namespace stbvh {

enum class Isa { kScalar, kAvx2, kAvx512 };

/// "scalar", "avx2", "avx512" (F, VL, DQ and BW).
std::string_view isa_name(Isa isa);

/// Instruction sets that this machine can run and this library was built with, slowest first.
std::vector<Isa> available_isas();

/// The instruction set in use: the fastest available one, or what the environment variable STBVH_ISA names.
/// Read once; an unknown or unavailable name gives the default and one line on stderr, as does a machine
/// without AVX2.
Isa default_isa();

}  // namespace stbvh
