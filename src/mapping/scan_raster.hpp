#pragma once

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

/// The cells of one scan as two bits each: passed, hit. Neighbouring beams cross the same cells
/// near the lidar again and again; here that costs a bit in a few kilobytes, and the map itself is
/// touched once a cell, in order.
class ScanRaster {
 public:
  static constexpr int kWordBits = 64;

  /// An empty raster of the cells with low.column <= column <= high.column, low.row <= row <=
  /// high.row.
  void start(Cell low, Cell high) {
    low_ = {low.column / kWordBits * kWordBits, low.row};
    words_per_row_ = static_cast<std::size_t>((high.column - low_.column) / kWordBits) + 1;
    rows_ = high.row - low.row + 1;
    const std::size_t words = words_per_row_ * static_cast<std::size_t>(rows_);
    if (words > passed_.size()) {  // all words are 0 between scans: finish() leaves them so
      passed_.resize(words);
      hit_.resize(words);
    }
  }

  void mark_hit(Cell cell) {
    const auto column = static_cast<unsigned>(cell.column - low_.column);
    hit_[row_start(cell.row) + column / kWordBits] |= std::uint64_t{1} << (column % kWordBits);
  }

  /// Cells first_column to last_column, both included.
  void mark_passed(int row, int first_column, int last_column) {
    const auto first = static_cast<unsigned>(first_column - low_.column);
    const auto last = static_cast<unsigned>(last_column - low_.column);
    std::uint64_t* word = passed_.data() + row_start(row) + first / kWordBits;
    const std::uint64_t from_first = ~std::uint64_t{0} << (first % kWordBits);
    const std::uint64_t to_last = ~std::uint64_t{0} >> (kWordBits - 1 - last % kWordBits);
    if (first / kWordBits == last / kWordBits) {
      *word |= from_first & to_last;
      return;
    }
    *word++ |= from_first;
    for (unsigned w = first / kWordBits + 1; w < last / kWordBits; ++w) *word++ = ~std::uint64_t{0};
    *word |= to_last;
  }

  /// Calls on_word(row, column of bit 0, passed but not hit, hit) for every word that is not empty;
  /// leaves the raster empty.
  template <typename OnWord>
  void finish(OnWord&& on_word) {
    for (int r = 0; r < rows_; ++r) {
      for (std::size_t w = 0; w < words_per_row_; ++w) {
        const std::size_t i = static_cast<std::size_t>(r) * words_per_row_ + w;
        if ((passed_[i] | hit_[i]) == 0) continue;
        on_word(low_.row + r, low_.column + static_cast<int>(w) * kWordBits, passed_[i] & ~hit_[i],
                hit_[i]);
        passed_[i] = 0;
        hit_[i] = 0;
      }
    }
  }

 private:
  [[nodiscard]] std::size_t row_start(int row) const {
    assert(row >= low_.row && row < low_.row + rows_);
    return static_cast<std::size_t>(row - low_.row) * words_per_row_;
  }

  Cell low_{};
  std::size_t words_per_row_ = 0;
  int rows_ = 0;
  std::vector<std::uint64_t> passed_{};
  std::vector<std::uint64_t> hit_{};
};

}  // namespace loopstone
