#include "loopstone/localization/histogram_filter.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

/// Cells where the belief has a peak: above the threshold, and no neighbour higher. One a peak.
std::vector<int> peaks(const HistogramFilter& belief, double threshold) {
  std::vector<int> found;
  bool inside = false;
  for (int column = 0; column < belief.shape().columns; ++column) {
    const bool above = belief.probability({column, 0}) > threshold;
    if (above && !inside) found.push_back(column);
    if (above && belief.probability({column, 0}) > belief.probability({found.back(), 0})) {
      found.back() = column;
    }
    inside = above;
  }
  return found;
}

// Thrun, Burgard and Fox 2005, figure 1.2: a robot in a corridor with three doors, told nothing but
// "I see a door".
TEST(HistogramFilter, FindsItselfInTheCorridorWithThreeDoors) {
  constexpr int kDoors[] = {20, 35, 75};
  const auto sees_door = [&](Cell cell) {
    const bool at_door = std::any_of(std::begin(kDoors), std::end(kDoors),
                                     [&](int door) { return std::abs(cell.column - door) <= 1; });
    return at_door ? 0.8 : 0.1;
  };
  HistogramFilter belief({.columns = 100, .column_edge = GridEdge::kRing});
  EXPECT_TRUE(peaks(belief, 0.0101).empty()) << "at first it may be anywhere";

  EXPECT_NEAR(belief.update(sees_door), (9 * 0.8 + 91 * 0.1) / 100.0, 1e-12);
  EXPECT_EQ(peaks(belief, 0.03).size(), 3U) << "a door, but which?";

  belief.predict(normal_kernel(15.0, 1.0));
  EXPECT_EQ(peaks(belief, 0.02).size(), 3U) << "moving shifts and blurs";

  (void)belief.update(sees_door);
  const std::vector<int> now = peaks(belief, 0.05);
  ASSERT_EQ(now.size(), 1U) << "only one door has another one 15 cells before it";
  EXPECT_NEAR(now[0], 35, 1);
}

/// p(readings) and p(last cell | readings) by adding up every path through the cells.
struct Enumerated {
  std::vector<double> joint;
  [[nodiscard]] double evidence() const {
    double sum = 0.0;
    for (const double value : joint) sum += value;
    return sum;
  }
};

void enumerate(const HistogramShape& shape, const std::vector<KernelCell>& kernel,
               const std::vector<std::vector<double>>& likelihoods, std::size_t step, Cell cell,
               double probability, Enumerated& result) {
  if (step == likelihoods.size()) {
    result.joint[shape.index_of(cell)] += probability;
    return;
  }
  for (const KernelCell& part : kernel) {
    int column = cell.column + part.shift.column;
    int row = cell.row + part.shift.row;
    if (shape.column_edge == GridEdge::kRing) {
      while (column < 0) column += shape.columns;
      while (column >= shape.columns) column -= shape.columns;
    } else {
      column = std::min(std::max(column, 0), shape.columns - 1);
    }
    if (shape.row_edge == GridEdge::kRing) {
      while (row < 0) row += shape.rows;
      while (row >= shape.rows) row -= shape.rows;
    } else {
      row = std::min(std::max(row, 0), shape.rows - 1);
    }
    const Cell next{column, row};
    enumerate(shape, kernel, likelihoods, step + 1, next,
              probability * part.probability * likelihoods[step][shape.index_of(next)], result);
  }
}

RC_GTEST_PROP(HistogramFilter, AgreesWithTheSumOverAllPaths, ()) {
  const auto any_edge = rc::gen::element(GridEdge::kWall, GridEdge::kRing);
  const HistogramShape shape{.columns = *rc::gen::inRange(1, 5),
                             .rows = *rc::gen::inRange(1, 4),
                             .column_edge = *any_edge,
                             .row_edge = *any_edge};
  Rng rng(*rc::gen::arbitrary<std::uint64_t>());
  const auto kernel =
      plane_kernel(normal_kernel(rng.uniform(-6.0, 6.0), 0.3), normal_kernel(0.4, 0.0));
  std::vector<double> prior(shape.cell_count());
  for (double& value : prior) value = rng.uniform();
  std::vector<std::vector<double>> likelihoods(3, std::vector<double>(shape.cell_count()));
  for (auto& step : likelihoods) {
    for (double& value : step) value = rng.uniform(0.0, 2.0);
  }

  HistogramFilter filter(shape, prior);
  Enumerated naive{std::vector<double>(shape.cell_count(), 0.0)};
  for (int row = 0; row < shape.rows; ++row) {
    for (int column = 0; column < shape.columns; ++column) {
      const Cell cell{column, row};
      enumerate(shape, kernel, likelihoods, 0, cell, filter.probability(cell), naive);
    }
  }
  double evidence = 1.0;
  for (const auto& step : likelihoods) {
    filter.predict(kernel);
    evidence *= filter.reweight(step);
  }
  RC_ASSERT(std::abs(evidence - naive.evidence()) < 1e-12);
  for (std::size_t i = 0; i < shape.cell_count(); ++i) {
    RC_ASSERT(std::abs(filter.probabilities()[i] - naive.joint[i] / naive.evidence()) < 1e-9);
  }
}

TEST(HistogramFilter, KernelsKeepTheMean) {
  for (const double sigma : {0.0, 0.2, 3.0}) {
    for (const double shift : {0.0, 2.0, -1.25, 3.5}) {
      double total = 0.0;
      double mean = 0.0;
      double square = 0.0;
      for (const KernelCell& cell : normal_kernel(shift, sigma)) {
        total += cell.probability;
        mean += cell.probability * cell.shift.column;
        square += cell.probability * cell.shift.column * cell.shift.column;
      }
      EXPECT_NEAR(total, 1.0, 1e-12);
      if (sigma == 0.2) continue;  // much narrower than a cell: the nearest cell takes it all
      EXPECT_NEAR(mean, shift, 1e-3);
      // A cell's width adds 1/12; the cut at four sigma takes a little.
      if (sigma == 3.0) {
        EXPECT_NEAR(square - mean * mean, sigma * sigma + 1.0 / 12.0, 0.05);
      }
    }
  }
}

TEST(HistogramFilter, SaysWhenNoCellExplainsAReading) {
  HistogramFilter belief({.columns = 3}, {1.0, 0.0, 1.0});
  EXPECT_EQ(belief.update([](Cell cell) { return cell.column == 1 ? 1.0 : 0.0; }), 0.0);
  EXPECT_EQ(belief.probabilities(), (std::vector<double>{0.5, 0.0, 0.5}));
}

TEST(HistogramFilter, RefusesNonsense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(HistogramFilter({.columns = 0}), UsageError);
  EXPECT_THROW(HistogramFilter({.columns = -2, .rows = -2}), UsageError);
  EXPECT_THROW(HistogramFilter({.columns = 2}, {1.0}), UsageError);
  EXPECT_THROW(HistogramFilter({.columns = 2}, {0.0, 0.0}), UsageError);
  HistogramFilter belief({.columns = 2});
  EXPECT_THROW(belief.update([&](Cell) { return nan; }), UsageError);
  EXPECT_THROW(belief.update([&](Cell) { return -1.0; }), UsageError);
  EXPECT_THROW(belief.predict(std::vector<KernelCell>{{{0, 0}, 0.5}}), UsageError);
  EXPECT_THROW(belief.predict(std::vector<KernelCell>{{{0, 0}, 1.5}, {{1, 0}, -0.5}}), UsageError);
  EXPECT_THROW((void)normal_kernel(nan, 1.0), UsageError);
  EXPECT_EQ(belief.probabilities(), (std::vector<double>{0.5, 0.5}));
}

}  // namespace
}  // namespace loopstone
