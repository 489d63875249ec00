#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace loopstone {

/// The same as std::floor for values that fit, without a call on processors that have no
/// instruction for it. Others become the nearest number that fits, NaN the lowest.
[[nodiscard]] inline int floor_to_int(double value) {
  constexpr double kMost = 2147483647.0;
  const double fitting = value > -kMost ? (value < kMost ? value : kMost) : -kMost;
  const auto whole = static_cast<int>(fitting);
  return whole - static_cast<int>(static_cast<double>(whole) > fitting);
}

/// A cell: column grows with x, row grows with y; (0, 0) is the lower left cell.
struct Cell {
  int column = 0;
  int row = 0;
  friend bool operator==(const Cell&, const Cell&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(column, row);
  }
};

/// Where a grid lies in the plane: the one place where metres become cells and back.
struct GridFrame {
  Eigen::Vector2d origin{0.0, 0.0};  ///< lower-left corner of cell (0, 0) [m]
  double resolution = 0.05;          ///< side of a cell [m]
  int columns = 0;
  int rows = 0;

  [[nodiscard]] Cell cell_of(const Eigen::Vector2d& point) const {
    return {floor_to_int((point.x() - origin.x()) / resolution),
            floor_to_int((point.y() - origin.y()) / resolution)};
  }
  [[nodiscard]] Eigen::Vector2d centre_of(Cell cell) const {
    return {origin.x() + (cell.column + 0.5) * resolution,
            origin.y() + (cell.row + 0.5) * resolution};
  }
  [[nodiscard]] bool contains(Cell cell) const {
    return cell.column >= 0 && cell.row >= 0 && cell.column < columns && cell.row < rows;
  }
  [[nodiscard]] std::size_t index_of(Cell cell) const {
    return static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(cell.column);
  }
  [[nodiscard]] std::size_t cell_count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  friend bool operator==(const GridFrame&, const GridFrame&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(origin, resolution, columns, rows);
    a.check(columns >= 0 && rows >= 0, "a grid of negative size");
  }
};

/// The smallest frame with that resolution, corners on whole multiples of it, that covers the box
/// [low, high] and a margin around it. Throws UsageError when it would have more than 2^30 cells.
[[nodiscard]] GridFrame frame_covering(const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                                       double resolution, double margin_m = 0.0);

}  // namespace loopstone
