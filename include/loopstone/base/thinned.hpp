#pragma once

#include <algorithm>
#include <cstddef>
#include <ranges>
#include <vector>

namespace loopstone {

/// Values spread evenly over the range so that no more than `count` are left; all of them when
/// there are no more.
template <std::ranges::random_access_range Values>
[[nodiscard]] std::vector<std::ranges::range_value_t<Values>> thinned(const Values& values,
                                                                      std::size_t count) {
  const auto size = static_cast<std::size_t>(std::ranges::size(values));
  const std::size_t wanted = std::min(count, size);
  std::vector<std::ranges::range_value_t<Values>> kept;
  kept.reserve(wanted);
  for (std::size_t i = 0; i < wanted; ++i)
    kept.push_back(values[static_cast<std::ranges::range_difference_t<Values>>(i * size / wanted)]);
  return kept;
}

}  // namespace loopstone
