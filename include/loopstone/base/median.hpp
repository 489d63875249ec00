#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace loopstone {

/// Standard deviation = this times the median of the absolute values, for normal noise.
inline constexpr double kSigmaPerMedian = 1.4826;

/// The middle value, of an even number the upper one; 0 for none. Reorders the values. Cost:
/// O(values).
template <typename Value>
[[nodiscard]] Value median_of(std::vector<Value>& values) {
  if (values.empty()) return Value{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace loopstone
