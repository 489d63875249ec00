#include "loopstone/localization/histogram_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "loopstone/base/error_function.hpp"

namespace loopstone {

namespace {

int moved_on_axis(int from, int shift, int size, GridEdge edge) {
  if (edge == GridEdge::kWall) return std::clamp(from + shift, 0, size - 1);
  const int rest = (from + shift) % size;
  return rest < 0 ? rest + size : rest;
}

double normal_cumulative(double z) {
  return 0.5 * complementary_error_function(-z / std::numbers::sqrt2);
}

}  // namespace

Cell HistogramShape::moved(Cell cell, Cell shift) const {
  return {moved_on_axis(cell.column, shift.column, columns, column_edge),
          moved_on_axis(cell.row, shift.row, rows, row_edge)};
}

std::vector<KernelCell> normal_kernel(double shift_cells, double sigma_cells) {
  if (!(std::abs(shift_cells) < 1e6 && sigma_cells >= 0.0 && sigma_cells < 1e5)) {
    throw UsageError("a motion kernel needs a finite shift and a noise that is not negative");
  }
  std::vector<KernelCell> kernel;
  if (sigma_cells == 0.0) {
    const int below = floor_to_int(shift_cells);
    const double fraction = shift_cells - below;
    kernel.push_back({{below, 0}, 1.0 - fraction});
    if (fraction > 0.0) kernel.push_back({{below + 1, 0}, fraction});
    return kernel;
  }
  const int first = floor_to_int(shift_cells - 4.0 * sigma_cells + 0.5);
  const int last = floor_to_int(shift_cells + 4.0 * sigma_cells + 0.5);
  double total = 0.0;
  for (int shift = first; shift <= last; ++shift) {
    const double probability = normal_cumulative((shift + 0.5 - shift_cells) / sigma_cells) -
                               normal_cumulative((shift - 0.5 - shift_cells) / sigma_cells);
    kernel.push_back({{shift, 0}, probability});
    total += probability;
  }
  for (KernelCell& cell : kernel) cell.probability /= total;
  return kernel;
}

std::vector<KernelCell> plane_kernel(std::span<const KernelCell> column_motion,
                                     std::span<const KernelCell> row_motion) {
  std::vector<KernelCell> kernel;
  kernel.reserve(column_motion.size() * row_motion.size());
  for (const KernelCell& row : row_motion) {
    for (const KernelCell& column : column_motion) {
      kernel.push_back(
          {{column.shift.column, row.shift.column}, column.probability * row.probability});
    }
  }
  return kernel;
}

HistogramFilter::HistogramFilter(const HistogramShape& shape)
    : HistogramFilter(
          shape,
          std::vector<double>(shape.columns > 0 && shape.rows > 0 ? shape.cell_count() : 0, 1.0)) {}

HistogramFilter::HistogramFilter(const HistogramShape& shape, std::vector<double> probabilities)
    : shape_(shape), probabilities_(probabilities.size(), 1.0) {
  if (shape.columns <= 0 || shape.rows <= 0 || probabilities.size() != shape.cell_count()) {
    throw UsageError("a histogram filter needs at least one cell, and one probability for each");
  }
  if (reweight(probabilities) == 0.0) {
    throw UsageError("a histogram filter needs a cell whose probability is above zero");
  }
}

void HistogramFilter::predict(std::span<const KernelCell> kernel) {
  double total = 0.0;
  bool negative = false;
  for (const KernelCell& part : kernel) {
    total += part.probability;
    negative = negative || !(part.probability >= 0.0);
  }
  if (negative || !(std::abs(total - 1.0) < 1e-9)) {
    throw UsageError("the probabilities of a motion kernel sum to " + std::to_string(total) +
                     "; they must not be negative and must sum to 1");
  }
  std::vector<double> moved(probabilities_.size(), 0.0);
  for (int row = 0; row < shape_.rows; ++row) {
    for (int column = 0; column < shape_.columns; ++column) {
      const Cell cell{column, row};
      const double belief = probability(cell);
      if (belief == 0.0) continue;
      for (const KernelCell& part : kernel) {
        moved[shape_.index_of(shape_.moved(cell, part.shift))] +=
            belief * (part.probability / total);
      }
    }
  }
  probabilities_ = std::move(moved);
}

double HistogramFilter::reweight(std::span<const double> likelihoods) {
  if (likelihoods.size() != probabilities_.size()) {
    throw UsageError("a histogram filter needs one likelihood for each cell");
  }
  std::vector<double> products(probabilities_);
  double evidence = 0.0;
  for (std::size_t i = 0; i < products.size(); ++i) {
    if (!(likelihoods[i] >= 0.0 && std::isfinite(likelihoods[i]))) {
      throw UsageError("the likelihood of cell " + std::to_string(i) + " is " +
                       std::to_string(likelihoods[i]) + "; it must be finite and not negative");
    }
    products[i] *= likelihoods[i];
    evidence += products[i];
  }
  if (!std::isfinite(evidence))
    throw UsageError("likelihoods are too large to be summed; scale them down");
  if (evidence == 0.0) return 0.0;
  for (double& product : products) product /= evidence;
  probabilities_ = std::move(products);
  return evidence;
}

}  // namespace loopstone
