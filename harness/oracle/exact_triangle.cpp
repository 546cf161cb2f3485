#include "harness/oracle/exact_triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>

#include "harness/scenes/moving_triangle.h"

namespace stbvh::harness {
namespace {

using ExactVec3 = std::array<mpz_class, 3>;

constexpr long kExponentOfZero = std::numeric_limits<long>::max();

/// mantissa * 2^exponent, the mantissa odd or 0.
struct Dyadic {
  long mantissa = 0;
  long exponent = kExponentOfZero;
};

Dyadic dyadic(float x) {
  if (x == 0) return {};
  int exponent = 0;
  const long mantissa = static_cast<long>(std::ldexp(std::frexp(x, &exponent), 24));
  const int zeros = std::countr_zero(static_cast<unsigned long>(mantissa));
  return {mantissa / (1L << zeros), exponent - 24 + zeros};
}

/// All of `values` are integers times 2 to this power.
long common_exponent(std::initializer_list<Vec3f> values) {
  long least = kExponentOfZero;
  for (const Vec3f& p : values) {
    least = std::min({least, dyadic(p.x).exponent, dyadic(p.y).exponent, dyadic(p.z).exponent});
  }
  return least == kExponentOfZero ? 0 : least;
}

/// x / 2^exponent, where that is an integer.
mpz_class scaled(Dyadic x, long exponent) {
  if (x.mantissa == 0) return 0;
  return mpz_class(x.mantissa) << static_cast<mp_bitcnt_t>(x.exponent - exponent);
}

ExactVec3 scaled(Vec3f p, long exponent) {
  return {scaled(dyadic(p.x), exponent), scaled(dyadic(p.y), exponent), scaled(dyadic(p.z), exponent)};
}

mpz_class dot(const ExactVec3& a, const ExactVec3& b) {
  mpz_class sum = a[0] * b[0];
  mpz_addmul(sum.get_mpz_t(), a[1].get_mpz_t(), b[1].get_mpz_t());
  mpz_addmul(sum.get_mpz_t(), a[2].get_mpz_t(), b[2].get_mpz_t());
  return sum;
}

ExactVec3 cross(const ExactVec3& a, const ExactVec3& b) {
  ExactVec3 across;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t i = (axis + 1) % 3;
    const std::size_t j = (axis + 2) % 3;
    across[axis] = a[i] * b[j];
    mpz_submul(across[axis].get_mpz_t(), a[j].get_mpz_t(), b[i].get_mpz_t());
  }
  return across;
}

/// Where a time lies in a mesh's grid of steps; `length` and `along` share a scale.
struct ExactMotion {
  std::size_t segment = 0;
  mpz_class length = 1;  ///< b - a, or t_(k+1) - t_k
  mpz_class along = 0;   ///< (t - a) S - k (b - a), or t - t_k
};

ExactMotion exact_motion_among_times(const Mesh& mesh, float time) {
  ExactMotion motion;
  motion.segment = segment_among_times(mesh, time);
  const Vec3f times{mesh.step_times[motion.segment], mesh.step_times[motion.segment + 1], time};
  const ExactVec3 t = scaled(times, common_exponent({times}));
  motion.length = t[1] - t[0];
  motion.along = t[2] - t[0];
  return motion;
}

ExactMotion exact_motion(const Mesh& mesh, float time) {
  ExactMotion motion;
  if (mesh.is_static()) return motion;
  if (mesh.has_step_times()) return exact_motion_among_times(mesh, time);
  const Vec3f times{mesh.time_range.begin, mesh.time_range.end, time};
  const ExactVec3 t = scaled(times, common_exponent({times}));
  motion.length = t[1] - t[0];
  motion.along = (t[2] - t[0]) * mesh.segment_count();
  const mpz_class segment = motion.along / motion.length;
  motion.segment = std::min<std::size_t>(segment.get_ui(), mesh.segment_count() - 1);
  motion.along -= motion.segment * motion.length;
  return motion;
}

/// Sign of a 2^shift - b.
int compare_shifted(mpz_class a, long shift, mpz_class b) {
  if (shift >= 0) {
    a <<= static_cast<mp_bitcnt_t>(shift);
  } else {
    b <<= static_cast<mp_bitcnt_t>(-shift);
  }
  return cmp(a, b);
}

/// The double nearest to n / d * 2^exponent (or one ulp from it where it is denormal).
double nearest_double(mpz_class n, mpz_class d, long exponent) {
  const int sign = sgn(n) * sgn(d);
  if (sign == 0) return 0;
  n = abs(n);
  d = abs(d);
  const auto bits = [](const mpz_class& x) { return static_cast<long>(mpz_sizeinbase(x.get_mpz_t(), 2)); };
  // A quotient of 63 or 64 bits; what remains only matters as more than nothing.
  const long shift = 63 - (bits(n) - bits(d));
  if (shift >= 0) {
    n <<= static_cast<mp_bitcnt_t>(shift);
  } else {
    d <<= static_cast<mp_bitcnt_t>(-shift);
  }
  const mpz_class quotient = n / d;
  const std::uint64_t sticky = quotient * d != n ? 1 : 0;
  return sign *
         std::ldexp(static_cast<double>(quotient.get_ui() | sticky), static_cast<int>(exponent - shift));
}

}  // namespace

ExactTriangle::ExactTriangle(const Ray& ray, const Mesh& mesh, std::size_t prim) {
  const ExactMotion motion = exact_motion(mesh, ray.time);
  const VertexBuffer& begin = mesh.steps[motion.segment];
  const VertexBuffer& end = mesh.steps[std::min(motion.segment + 1, mesh.segment_count())];
  const std::uint32_t* v = &mesh.indices[3 * prim];
  const long unit =
      common_exponent({begin[v[0]], begin[v[1]], begin[v[2]], end[v[0]], end[v[1]], end[v[2]], ray.origin});
  const ExactVec3 origin = scaled(ray.origin, unit);
  std::array<ExactVec3, 3> q;
  for (std::size_t c = 0; c < 3; ++c) {
    const ExactVec3 from = scaled(begin[v[c]], unit);
    const ExactVec3 to = scaled(end[v[c]], unit);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      q[c][axis] = motion.length * (from[axis] - origin[axis]) + motion.along * (to[axis] - from[axis]);
    }
  }
  const long direction_unit = common_exponent({ray.direction});
  const ExactVec3 direction = scaled(ray.direction, direction_unit);
  const ExactVec3 across = cross(q[1], q[2]);
  weights_ = {dot(direction, across), dot(direction, cross(q[2], q[0])), dot(direction, cross(q[0], q[1]))};
  facing_ = weights_[0] + weights_[1] + weights_[2];
  numerator_ = dot(q[0], across);
  denominator_ = motion.length * facing_;
  if (sgn(denominator_) < 0) {
    numerator_ = -numerator_;
    denominator_ = -denominator_;
  }
  exponent_ = unit - direction_unit;
}

bool ExactTriangle::is_covered() const {
  const int sign = sgn(facing_);
  return sign != 0 && std::all_of(weights_.begin(), weights_.end(),
                                  [&](const mpz_class& w) { return sgn(w) * sign >= 0; });
}

int ExactTriangle::compare_t(float bound) const {
  if (std::isinf(bound)) return bound > 0 ? -1 : 1;
  const Dyadic x = dyadic(bound);
  if (x.mantissa == 0) return sgn(numerator_);
  return compare_shifted(numerator_, exponent_ - x.exponent, x.mantissa * denominator_);
}

int ExactTriangle::compare_t(const ExactTriangle& other) const {
  return compare_shifted(numerator_ * other.denominator_, exponent_ - other.exponent_,
                         other.numerator_ * denominator_);
}

double ExactTriangle::t() const {
  return nearest_double(numerator_, denominator_, exponent_);
}

double ExactTriangle::u() const {
  return nearest_double(weights_[1], facing_, 0);
}

double ExactTriangle::v() const {
  return nearest_double(weights_[2], facing_, 0);
}

}  // namespace stbvh::harness
