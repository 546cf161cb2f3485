/// What results are about.
#pragma once

#include <algorithm>
#include <functional>
#include <type_traits>
#include <vector>

namespace stbvh::harness {

/// The values of a field (a member, or a function of a result), each once, in the order in which they first
/// occur.
template <class Result, class Field>
auto distinct(const std::vector<Result>& results, const Field& field) {
  std::vector<std::decay_t<std::invoke_result_t<const Field&, const Result&>>> values;
  for (const Result& r : results) {
    const auto& value = std::invoke(field, r);
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
  return values;
}

}  // namespace stbvh::harness
