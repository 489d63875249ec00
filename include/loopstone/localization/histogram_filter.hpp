#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

/// What lies beyond the last cell of an axis.
enum class GridEdge {
  kWall,  ///< a motion that would leave ends at the last cell
  kRing,  ///< the first cell follows
};

/// The cells of a histogram: a line is a plane of one row.
struct HistogramShape {
  int columns = 1;
  int rows = 1;
  GridEdge column_edge = GridEdge::kWall;  ///< beyond the first and last column
  GridEdge row_edge = GridEdge::kWall;     ///< beyond the first and last row

  [[nodiscard]] std::size_t cell_count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  [[nodiscard]] std::size_t index_of(Cell cell) const {
    return static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(cell.column);
  }
  /// Where a motion from `cell` ends.
  [[nodiscard]] Cell moved(Cell cell, Cell shift) const;
};

/// One of the shifts that a motion may turn out to be.
struct KernelCell {
  Cell shift;
  double probability = 0.0;
};

/// A motion along the columns by `shift_cells`, normally distributed: each whole shift gets the
/// probability of its cell, cut at four standard deviations. Without noise a fraction of a cell is
/// shared by the two neighbours.
[[nodiscard]] std::vector<KernelCell> normal_kernel(double shift_cells, double sigma_cells);

/// Independent motions along both axes; of `row_motion` the columns are read as rows.
[[nodiscard]] std::vector<KernelCell> plane_kernel(std::span<const KernelCell> column_motion,
                                                   std::span<const KernelCell> row_motion);

/// A belief over the cells of a grid: the Bayes filter that can be checked by hand. Probabilities
/// always sum to one.
///
///   HistogramFilter belief({.columns = 100, .column_edge = GridEdge::kRing});
///   const double evidence = belief.update([&](Cell cell) { return is_door(cell) ? 0.9 : 0.1; });
///   belief.predict(normal_kernel(10.0, 1.0));
///
/// Source: Thrun, Burgard and Fox 2005, "Probabilistic Robotics", table 4.1.
class HistogramFilter {
 public:
  /// Every cell equally likely. Throws UsageError without cells.
  explicit HistogramFilter(const HistogramShape& shape);
  /// Cells row by row; scaled to sum to one. Throws UsageError for a wrong number of cells, for
  /// values that are not finite or negative, and where all are zero.
  HistogramFilter(const HistogramShape& shape, std::vector<double> probabilities);

  [[nodiscard]] const HistogramShape& shape() const { return shape_; }
  [[nodiscard]] const std::vector<double>& probabilities() const { return probabilities_; }
  [[nodiscard]] double probability(Cell cell) const {
    return probabilities_[shape_.index_of(cell)];
  }

  /// Moves the belief. The kernel's probabilities must sum to one (UsageError). Cost: O(cells *
  /// kernel).
  void predict(std::span<const KernelCell> kernel);

  /// Weighs every cell by likelihood(Cell) -> p(reading | cell), and returns the evidence p(reading
  /// | readings before). 0: no cell can explain the reading; the belief stays as it was. Throws
  /// UsageError for likelihoods that are negative or not finite.
  template <typename Likelihood>
  double update(const Likelihood& likelihood) {
    std::vector<double> likelihoods(probabilities_.size());
    for (int row = 0; row < shape_.rows; ++row) {
      for (int column = 0; column < shape_.columns; ++column) {
        const Cell cell{column, row};
        likelihoods[shape_.index_of(cell)] = likelihood(cell);
      }
    }
    return reweight(likelihoods);
  }
  /// update with likelihoods computed elsewhere, one a cell, row by row.
  double reweight(std::span<const double> likelihoods);

 private:
  HistogramShape shape_;
  std::vector<double> probabilities_;
};

}  // namespace loopstone
