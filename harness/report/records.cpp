#include "harness/report/records.h"

#include <algorithm>
#include <cmath>

namespace stbvh::harness {

Spread spread_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  const double median = n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
  return {median, values.front(), values.back()};
}

double geometric_mean(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += std::log(value);
  return values.empty() ? 0 : std::exp(sum / static_cast<double>(values.size()));
}

std::optional<Spread> SpeedResult::ratio_to_embree() const {
  return ratios_to_embree.empty() ? std::nullopt : std::optional(spread_of(ratios_to_embree));
}

double rate_bound_95(std::size_t count, std::size_t n) {
  if (n == 0) return 1;
  if (count == 0) return std::min(1.0, 3.0 / static_cast<double>(n));
  const double k = static_cast<double>(count) + 1;
  const double root = 1 - 1 / (9 * k) + 1.645 / (3 * std::sqrt(k));
  return std::min(1.0, k * root * root * root / static_cast<double>(n));
}

double FramesResult::crossover_rays() const {
  const double set_up = frame_build_s - build_s / static_cast<double>(frames);  // that one for all saves
  const double of_a_ray = 1e-6 / mrays_per_s - 1e-6 / frame_mrays_per_s;        // that it costs more
  if (of_a_ray <= 0) return set_up >= 0 ? -1 : 0;
  return std::max(set_up / of_a_ray, 0.0);
}

}  // namespace stbvh::harness
