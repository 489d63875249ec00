#include "loopstone/grid/max_pyramid.hpp"

#include <algorithm>

namespace loopstone {

namespace {

constexpr std::size_t kPad = MaxPyramid::kLanes;

/// An empty level, all outside. Windows that start up to 2^level - 1 cells before the grid reach
/// into it.
MaxPyramid::Level make_level(const GridFrame& frame, int level, std::uint8_t outside) {
  MaxPyramid::Level made;
  made.level = level;
  made.lowest_index = level == 0 ? 0 : -1;
  made.highest_index = (frame.columns - 1) >> level;
  made.lowest_row = 1 - (1 << level);
  made.highest_row = frame.rows - 1;
  const auto entries = static_cast<std::uint32_t>(made.highest_index - made.lowest_index + 1);
  made.run_length = static_cast<std::uint32_t>(kPad) + entries;
  made.pitch = made.run_length << level;
  const int row_count = made.highest_row - made.lowest_row + 1;
  const auto rows = static_cast<std::size_t>(row_count);
  made.data.assign((rows + 1) * made.pitch + 2 * kPad, outside);
  return made;
}

/// out[i] = max(a[i], b[i])
void maximum(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, std::size_t count) {
  constexpr std::size_t kBlock = 16;
  std::size_t i = 0;
  for (; i + kBlock <= count; i += kBlock) {
    std::uint8_t block[kBlock];
    for (std::size_t k = 0; k < kBlock; ++k) block[k] = std::max(a[i + k], b[i + k]);
    std::copy_n(block, kBlock, out + i);
  }
  for (; i < count; ++i) out[i] = std::max(a[i], b[i]);
}

/// Windows of half the size stand side by side in `in`; joins neighbours, and sorts the results by
/// whether they start at an even or an odd one: even[i] = max(in[2i], in[2i + 1]), odd[i] =
/// max(in[2i + 1], in[2i + 2]).
void join_neighbours(const std::uint8_t* in, std::uint8_t* even, std::uint8_t* odd,
                     std::size_t count) {
  constexpr std::size_t kBlock = 16;
  std::size_t i = 0;
  for (; i + kBlock <= count; i += kBlock) {
    std::uint8_t joined[2 * kBlock];
    for (std::size_t k = 0; k < 2 * kBlock; ++k)
      joined[k] = std::max(in[2 * i + k], in[2 * i + k + 1]);
    std::uint8_t evens[kBlock];
    std::uint8_t odds[kBlock];
    for (std::size_t k = 0; k < kBlock; ++k) {
      evens[k] = joined[2 * k];
      odds[k] = joined[2 * k + 1];
    }
    std::copy_n(evens, kBlock, even + i);
    std::copy_n(odds, kBlock, odd + i);
  }
  for (; i < count; ++i) {
    even[i] = std::max(in[2 * i], in[2 * i + 1]);
    odd[i] = std::max(in[2 * i + 1], in[2 * i + 2]);
  }
}

/// The level above: each window is the union of four of half the size.
MaxPyramid::Level level_above(const MaxPyramid::Level& below, const GridFrame& frame,
                              std::uint8_t outside) {
  MaxPyramid::Level above = make_level(frame, below.level + 1, outside);
  const int shift = 1 << below.level;
  const int entry_count = above.highest_index - above.lowest_index + 1;
  const auto entries = static_cast<std::size_t>(entry_count);
  // Two entries more at either end stand for what lies before and behind the row.
  std::vector<std::uint8_t> row_maximum(below.pitch + 4 * kPad, outside);
  std::uint8_t* const joined_rows = row_maximum.data() + 2;
  for (int row = above.lowest_row; row <= above.highest_row; ++row) {
    maximum(&below.data[below.row_offset(row)], &below.data[below.row_offset(row + shift)],
            joined_rows, below.pitch);
    std::uint8_t* const out = &above.data[above.row_offset(row)];
    for (int run = 0; run < shift; ++run) {
      // Index -1 of the wider windows starts at index -2 of the narrower ones.
      const std::uint8_t* in = joined_rows + static_cast<std::size_t>(run) * below.run_length +
                               kPad - 2 - below.lowest_index;
      join_neighbours(in, out + static_cast<std::size_t>(run) * above.run_length + kPad,
                      out + static_cast<std::size_t>(run + shift) * above.run_length + kPad,
                      entries);
    }
  }
  return above;
}

}  // namespace

MaxPyramid::MaxPyramid(const Grid<std::uint8_t>& grid, int levels, std::uint8_t outside)
    : frame_(grid.frame()) {
  Level base = make_level(frame_, 0, outside);
  for (int row = 0; row < frame_.rows; ++row) {
    std::copy_n(grid.cells().begin() + static_cast<std::ptrdiff_t>(row) * frame_.columns,
                frame_.columns, &base.data[base.row_offset(row) + kPad]);
  }
  levels_.push_back(std::move(base));
  while (level_count() < levels) levels_.push_back(level_above(levels_.back(), frame_, outside));
}

std::size_t MaxPyramid::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Level& level : levels_) bytes += level.data.size();
  return bytes;
}

}  // namespace loopstone
