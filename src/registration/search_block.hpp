#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "loopstone/registration/correlative_search.hpp"

// What the branch-and-bound searches over a lattice of poses share.
namespace loopstone {

/// Square block of shifts at one heading, by its first column and row, and what none of them
/// exceeds.
struct SearchBlock {
  std::int32_t bound = 0;  ///< sum of the cells of all points
  std::int32_t heading = 0;
  std::int32_t column = 0;
  std::int32_t row = 0;
};

/// Is (heading, row, column) of a before that of b? Decides between equal scores.
[[nodiscard]] inline bool is_earlier(const SearchBlock& a, const SearchBlock& b) {
  if (a.heading != b.heading) return a.heading < b.heading;
  if (a.row != b.row) return a.row < b.row;
  return a.column < b.column;
}

/// Highest bound first; ties by position, so that the order never depends on the sort.
[[nodiscard]] inline bool is_more_promising(const SearchBlock& a, const SearchBlock& b) {
  if (a.bound != b.bound) return a.bound > b.bound;
  return is_earlier(a, b);
}

/// The smallest sum over so many points whose score is at least that.
[[nodiscard]] inline std::int32_t least_sum(double score, std::size_t points) {
  const double sum = static_cast<double>(points) * (kUnknown + score * (kSurface - kUnknown));
  return static_cast<std::int32_t>(std::ceil(sum));
}

/// [-1, 1], see SearchResult.
[[nodiscard]] inline double score_of(std::int32_t sum, std::size_t points) {
  return (static_cast<double>(sum) / static_cast<double>(points) - kUnknown) /
         (kSurface - kUnknown);
}

}  // namespace loopstone
