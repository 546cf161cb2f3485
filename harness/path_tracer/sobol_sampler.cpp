#include "harness/path_tracer/sobol_sampler.h"

namespace stbvh::harness {
namespace {

std::uint32_t reversed(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0F0F0F0Fu) | ((x & 0x0F0F0F0Fu) << 4);
  return __builtin_bswap32(x);
}

/// A permutation in which each bit is flipped by a hash of those below it (Laine and Karras 2011: products
/// with even numbers let no bit reach one below).
std::uint32_t flipped_by_lower_bits(std::uint32_t x, std::uint32_t seed) {
  x += seed;
  x ^= x * 0x6C50B47Cu;
  x ^= x * 0xB82F1E52u;
  x ^= x * 0xC7AFE638u;
  x ^= x * 0x8D22F6E6u;
  return x;
}

/// Owen's scrambling of the number whose digits are the bits from the lowest on: each digit is flipped by
/// a hash of those above it.
double scrambled(std::uint32_t reversed_digits, std::uint32_t seed) {
  return 0x1p-32 * reversed(flipped_by_lower_bits(reversed_digits, seed));
}

/// Digits, from the lowest bit on, of the second dimension of the Sobol sequence: the index times Pascal's
/// triangle modulo 2. Digit j is the sum of the bits i of the index for which C(i, j) is odd: those whose
/// binary digits hold all of j's (Lucas), summed up digit by digit.
std::uint32_t sobol_second(std::uint32_t index) {
  index ^= (index >> 1) & 0x55555555u;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 4) & 0x0F0F0F0Fu;
  index ^= (index >> 8) & 0x00FF00FFu;
  index ^= (index >> 16) & 0x0000FFFFu;
  return index;
}

/// Finalizer of SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t mixed(std::uint64_t z) {
  z += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

}  // namespace

SamplePoint scrambled_sobol(std::uint32_t index, std::uint32_t seed) {
  const std::uint64_t hash = mixed(seed);
  const auto low = static_cast<std::uint32_t>(hash), high = static_cast<std::uint32_t>(hash >> 32);
  // The order of the points is scrambled in the same way. The first dimension of Sobol's sequence has the
  // digits of the index itself.
  const std::uint32_t shuffled = reversed(flipped_by_lower_bits(reversed(index), low ^ 0x5851F42Du));
  return {scrambled(shuffled, low), scrambled(sobol_second(shuffled), high)};
}

SobolSampler::SobolSampler(std::uint64_t seed, std::uint64_t pixel, std::uint32_t sample)
    : stream_(mixed(mixed(seed) ^ pixel)), sample_(sample) {}

SamplePoint SobolSampler::pair(std::uint32_t dimension) const {
  return scrambled_sobol(sample_, static_cast<std::uint32_t>(mixed(stream_ + dimension)));
}

}  // namespace stbvh::harness
