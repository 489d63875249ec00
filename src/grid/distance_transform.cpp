#include "loopstone/grid/distance_transform.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace loopstone {
namespace {

/// Stands for "no occupied cell": larger than any squared distance in a grid, small enough to add
/// to.
constexpr std::int64_t kFar = std::int64_t{1} << 60;
constexpr std::size_t kLinesPerTask = 64;

/// Distance, in cells, to the nearest occupied cell of the same column, for a run of columns.
void distances_along_columns(const Grid<std::uint8_t>& occupied, std::size_t first_column,
                             std::size_t end_column, std::vector<std::int64_t>& squared) {
  const auto columns = static_cast<std::size_t>(occupied.frame().columns);
  const auto rows = static_cast<std::size_t>(occupied.frame().rows);
  constexpr std::int64_t kNone = std::int64_t{1} << 30;
  for (std::size_t row = 0; row < rows; ++row) {  // nearest below or here
    for (std::size_t c = first_column; c < end_column; ++c) {
      const std::size_t i = row * columns + c;
      const std::int64_t below = row == 0 ? kNone : squared[i - columns] + 1;
      squared[i] = occupied.cells()[i] != 0 ? 0 : std::min(below, kNone);
    }
  }
  for (std::size_t row = rows; row-- > 0;) {  // or above
    for (std::size_t c = first_column; c < end_column; ++c) {
      const std::size_t i = row * columns + c;
      if (row + 1 < rows) squared[i] = std::min(squared[i], squared[i + columns] + 1);
    }
  }
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t c = first_column; c < end_column; ++c) {
      std::int64_t& d = squared[row * columns + c];
      d = d >= kNone ? kFar : d * d;
    }
  }
}

/// The lower envelope of the parabolas (x - q)^2 + height[q] along one row.
class LowerEnvelope {
 public:
  explicit LowerEnvelope(std::size_t count) : vertex_(count), begins_(count) {}

  /// Replaces the row by the envelope's values.
  void apply(std::int64_t* row, std::size_t count) {
    parabolas_ = 0;
    for (std::size_t q = 0; q < count; ++q) {
      if (row[q] < kFar) add(static_cast<std::int64_t>(q), row);
    }
    if (parabolas_ == 0) return;
    values_.resize(count);
    std::size_t k = 0;
    for (std::size_t x = 0; x < count; ++x) {
      const auto position = static_cast<std::int64_t>(x);
      while (k + 1 < parabolas_ && begins_[k + 1] <= position) ++k;
      const std::int64_t offset = position - vertex_[k];
      values_[x] = offset * offset + row[vertex_[k]];
    }
    std::copy(values_.begin(), values_.end(), row);
  }

 private:
  void add(std::int64_t q, const std::int64_t* height) {
    std::int64_t begin = 0;
    while (parabolas_ > 0) {
      begin = first_cell_where_lower(q, vertex_[parabolas_ - 1], height);
      if (begin > begins_[parabolas_ - 1]) break;
      --parabolas_;
    }
    if (parabolas_ == 0) begin = 0;
    vertex_[parabolas_] = q;
    begins_[parabolas_++] = begin;
  }

  /// The first whole x at which the parabola of q lies below or at that of p < q, but not before 0.
  static std::int64_t first_cell_where_lower(std::int64_t q, std::int64_t p,
                                             const std::int64_t* height) {
    const std::int64_t numerator = (height[q] + q * q) - (height[p] + p * p);
    const std::int64_t denominator = 2 * (q - p);
    if (numerator <= 0) return 0;
    return (numerator + denominator - 1) / denominator;
  }

  std::vector<std::int64_t> vertex_;
  std::vector<std::int64_t> begins_;
  std::vector<std::int64_t> values_{};
  std::size_t parabolas_ = 0;
};

}  // namespace

Grid<float> distance_transform(const Grid<std::uint8_t>& occupied, Threads threads) {
  const GridFrame& frame = occupied.frame();
  const auto columns = static_cast<std::size_t>(frame.columns);
  const auto rows = static_cast<std::size_t>(frame.rows);
  Grid<float> distance(frame, std::numeric_limits<float>::infinity());
  if (occupied.empty()) return distance;

  std::vector<std::int64_t> squared(frame.cell_count());
  parallel_for((columns + kLinesPerTask - 1) / kLinesPerTask, threads, [&](std::size_t task) {
    const std::size_t first = task * kLinesPerTask;
    distances_along_columns(occupied, first, std::min(first + kLinesPerTask, columns), squared);
  });
  parallel_for((rows + kLinesPerTask - 1) / kLinesPerTask, threads, [&](std::size_t task) {
    LowerEnvelope envelope(columns);
    const std::size_t first = task * kLinesPerTask;
    for (std::size_t row = first; row < std::min(first + kLinesPerTask, rows); ++row) {
      std::int64_t* const line = squared.data() + row * columns;
      envelope.apply(line, columns);
      for (std::size_t c = 0; c < columns; ++c) {
        if (line[c] >= kFar) continue;
        distance.cells()[row * columns + c] =
            static_cast<float>(std::sqrt(static_cast<double>(line[c])) * frame.resolution);
      }
    }
  });
  return distance;
}

}  // namespace loopstone
