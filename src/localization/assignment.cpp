#include "localization/assignment.hpp"

#include <algorithm>
#include <limits>

namespace loopstone {

namespace {

using Assignment = std::vector<std::optional<std::size_t>>;

/// Each row's own best; nothing where two rows want the same column.
std::optional<Assignment> best_without_conflict(const GainTable& table) {
  Assignment assignment(table.rows);
  std::vector<bool> taken(table.columns, false);
  for (std::size_t row = 0; row < table.rows; ++row) {
    double best = 0.0;
    for (std::size_t column = 0; column < table.columns; ++column) {
      if (table.at(row, column) <= best) continue;
      best = table.at(row, column);
      assignment[row] = column;
    }
    if (!assignment[row]) continue;
    if (taken[*assignment[row]]) return std::nullopt;
    taken[*assignment[row]] = true;
  }
  return assignment;
}

/// Rows are added one by one; each time the cheapest alternating path leads to a free column. Row
/// and column 0 are marks.
Assignment hungarian(const GainTable& table) {
  // As many columns as rows at least: taking one of those added is taking nothing.
  const std::size_t columns = table.columns + table.rows;
  const auto cost = [&](std::size_t row, std::size_t column) {
    return column > table.columns ? 0.0 : -std::max(0.0, table.at(row - 1, column - 1));
  };
  std::vector<double> row_potential(table.rows + 1, 0.0);
  std::vector<double> column_potential(columns + 1, 0.0);
  std::vector<std::size_t> row_of(columns + 1, 0);
  std::vector<std::size_t> came_from(columns + 1, 0);
  for (std::size_t added = 1; added <= table.rows; ++added) {
    row_of[0] = added;
    std::size_t column = 0;
    std::vector<double> slack(columns + 1, std::numeric_limits<double>::infinity());
    std::vector<bool> visited(columns + 1, false);
    while (row_of[column] != 0) {
      visited[column] = true;
      const std::size_t row = row_of[column];
      double least = std::numeric_limits<double>::infinity();
      std::size_t next = 0;
      for (std::size_t j = 1; j <= columns; ++j) {
        if (visited[j]) continue;
        const double reduced = cost(row, j) - row_potential[row] - column_potential[j];
        if (reduced < slack[j]) {
          slack[j] = reduced;
          came_from[j] = column;
        }
        if (slack[j] < least) {
          least = slack[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j <= columns; ++j) {
        if (visited[j]) {
          row_potential[row_of[j]] += least;
          column_potential[j] -= least;
        } else {
          slack[j] -= least;
        }
      }
      column = next;
    }
    while (column != 0) {
      row_of[column] = row_of[came_from[column]];
      column = came_from[column];
    }
  }
  Assignment assignment(table.rows);
  for (std::size_t column = 1; column <= table.columns; ++column) {
    const std::size_t row = row_of[column];
    if (row != 0 && table.at(row - 1, column - 1) > 0.0) assignment[row - 1] = column - 1;
  }
  return assignment;
}

}  // namespace

Assignment best_assignment(const GainTable& table) {
  if (auto assignment = best_without_conflict(table)) return *std::move(assignment);
  return hungarian(table);
}

}  // namespace loopstone
