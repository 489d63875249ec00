#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace loopstone {

/// Gains of giving column c to row r, row-major. Rows and columns are given out at most once.
struct GainTable {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> gains{};

  [[nodiscard]] double at(std::size_t row, std::size_t column) const {
    return gains[row * columns + column];
  }
};

/// For each row its column, so that the sum of gains is largest; gains that are not above zero are
/// never taken.
/// Cost: O(rows * columns) where no column is the best of two rows, else O(rows^2 * (rows +
/// columns)).
/// Source: the Hungarian method with potentials, Kuhn 1955; Burkard, Dell'Amico and Martello 2009,
/// section 4.4.
[[nodiscard]] std::vector<std::optional<std::size_t>> best_assignment(const GainTable& table);

}  // namespace loopstone
