#include "registration/tile_reader.hpp"

#include <algorithm>
#include <cassert>

namespace loopstone {

namespace {

/// 16 bits hold 256 values of 8 bits.
constexpr std::size_t kAtOnce = 256;
/// More tiles than this are not worth their memory.
constexpr std::size_t kMostTiles = 1U << 25U;

constexpr auto kSide = static_cast<std::size_t>(kTileSide);

/// Entries of a run of tiles: those of the level and as many on either side as a tile reaches.
std::uint32_t run_length_of(const MaxPyramid::Level& level) {
  return static_cast<std::uint32_t>(level.highest_index - level.lowest_index + 1 + 2 * kTileSide);
}

/// The lowest row of windows that a tile can have something of.
int lowest_row_of(const MaxPyramid::Level& level) {
  return level.lowest_row - (kTileSide - 1) * (1 << level.level);
}

}  // namespace

CellArea cell_area(const GridFrame& frame, int half_cells, int side) {
  CellArea area;
  area.half_cells = half_cells;
  area.first_column = -half_cells - kTileSide * side;
  area.first_row = area.first_column;
  area.columns = frame.columns + half_cells + 1 - area.first_column;
  area.rows = frame.rows + half_cells + 1 - area.first_row;
  return area;
}

TileReader::TileReader(const MaxPyramid::Level& level, const CellArea& area)
    : level_(&level),
      first_column_(area.first_column - area.half_cells),
      first_row_(area.first_row - area.half_cells) {
  const int side = 1 << level.level;
  const int columns = area.columns + 2 * area.half_cells;
  const int rows = area.rows + 2 * area.half_cells + (kTileSide - 1) * side;
  column_offsets_.reserve(static_cast<std::size_t>(columns));
  for (int i = 0; i < columns; ++i) {
    const int column = first_column_ + i;
    column_offsets_.push_back(level.run_offset(column) + level.lane_offset(column >> level.level));
  }
  row_offsets_.reserve(static_cast<std::size_t>(rows));
  for (int i = 0; i < rows; ++i) row_offsets_.push_back(level.row_offset(first_row_ + i));
  const auto tile_rows = static_cast<std::size_t>(level.highest_row - lowest_row_of(level) + 2);
  tile_count_ = tile_rows * run_length_of(level) * static_cast<std::size_t>(side);
}

void TileReader::add(const CellList& cells, std::size_t begin, std::size_t end, int column, int row,
                     TileSums& sums) {
  // To lay a tile out costs a quarter of what it takes to put one together.
  if (tiles_.empty() && 4 * points_read_ > tile_count_ && tile_count_ < kMostTiles) lay_out();
  points_read_ += end - begin;
  for (; begin < end; begin += kAtOnce) {
    const std::size_t stop = std::min(begin + kAtOnce, end);
    if (tiles_.empty()) {
      add_from_level(cells, begin, stop, column, row, sums);
    } else {
      add_from_tiles(cells, begin, stop, column, row, sums);
    }
  }
}

void TileReader::add_widened(const CellList& cells, std::size_t begin, std::size_t end, int column,
                             int row, int margin, TileSums& sums) const {
  assert(tiles_.empty());
  for (; begin < end; begin += kAtOnce)
    widened_from_level(cells, begin, std::min(begin + kAtOnce, end), column, row, margin, sums);
}

/// Four windows, moved by the margin into the corners, cover the wider one.
void TileReader::widened_from_level(const CellList& cells, std::size_t begin, std::size_t end,
                                    int column, int row, int margin, TileSums& sums) const {
  std::array<std::uint16_t, 2 * kSide> lanes[kSide]{};
  const std::uint8_t* const data = level_->data.data();
  const std::uint32_t* const left = column_offsets_.data() + (column - margin);
  const std::uint32_t* const right = column_offsets_.data() + (column + margin);
  const std::uint32_t* const low = row_offsets_.data() + (row - margin);
  const std::uint32_t* const high = row_offsets_.data() + (row + margin);
  const std::int32_t* const columns = cells.columns.data();
  const std::int32_t* const rows = cells.rows.data();
  const std::size_t side = std::size_t{1} << static_cast<unsigned>(level_->level);
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint8_t* const at_left = data + left[columns[i]];
    const std::uint8_t* const at_right = data + right[columns[i]];
    for (std::size_t line = 0; line < kSide; ++line) {
      const std::uint32_t low_row = low[static_cast<std::size_t>(rows[i]) + line * side];
      const std::uint32_t high_row = high[static_cast<std::size_t>(rows[i]) + line * side];
      std::uint8_t largest[2 * kSide];
      for (std::size_t lane = 0; lane < 2 * kSide; ++lane) {
        largest[lane] = std::max(std::max(at_left[low_row + lane], at_right[low_row + lane]),
                                 std::max(at_left[high_row + lane], at_right[high_row + lane]));
      }
      for (std::size_t lane = 0; lane < 2 * kSide; ++lane)
        lanes[line][lane] = static_cast<std::uint16_t>(lanes[line][lane] + largest[lane]);
    }
  }
  for (std::size_t line = 0; line < kSide; ++line) {
    for (std::size_t lane = 0; lane < kSide; ++lane) sums[line * kSide + lane] += lanes[line][lane];
  }
}

void TileReader::add_from_level(const CellList& cells, std::size_t begin, std::size_t end,
                                int column, int row, TileSums& sums) const {
  // The compiler keeps these in registers: half of each is of blocks further to the right.
  std::array<std::uint16_t, 2 * kSide> lanes[kSide]{};
  const std::uint8_t* const data = level_->data.data();
  const std::uint32_t* const column_offsets = column_offsets_.data() + column;
  const std::uint32_t* const row_offsets = row_offsets_.data() + row;
  const std::int32_t* const columns = cells.columns.data();
  const std::int32_t* const rows = cells.rows.data();
  const std::size_t side = std::size_t{1} << static_cast<unsigned>(level_->level);
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint8_t* const at = data + column_offsets[columns[i]];
    const std::uint32_t* const lines = row_offsets + rows[i];
    for (std::size_t line = 0; line < kSide; ++line) {
      const std::uint8_t* const values = at + lines[line * side];
      for (std::size_t lane = 0; lane < 2 * kSide; ++lane)
        lanes[line][lane] = static_cast<std::uint16_t>(lanes[line][lane] + values[lane]);
    }
  }
  for (std::size_t line = 0; line < kSide; ++line) {
    for (std::size_t lane = 0; lane < kSide; ++lane) sums[line * kSide + lane] += lanes[line][lane];
  }
}

void TileReader::add_from_tiles(const CellList& cells, std::size_t begin, std::size_t end,
                                int column, int row, TileSums& sums) const {
  std::array<std::uint16_t, kSide * kSide> lanes{};
  const auto* const data = reinterpret_cast<const std::uint8_t*>(tiles_.data());
  const std::uint32_t* const column_offsets = column_offsets_.data() + column;
  const std::uint32_t* const row_offsets = row_offsets_.data() + row;
  const std::int32_t* const columns = cells.columns.data();
  const std::int32_t* const rows = cells.rows.data();
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t tile = column_offsets[columns[i]] + row_offsets[rows[i]];
    const std::uint8_t* const values = data + tile * kSide;
    for (std::size_t lane = 0; lane < lanes.size(); ++lane)
      lanes[lane] = static_cast<std::uint16_t>(lanes[lane] + values[lane]);
  }
  for (std::size_t line = 0; line < kSide; ++line) {
    for (std::size_t lane = 0; lane < kSide; ++lane)
      sums[line * kSide + lane] += lanes[lane * kSide + line];
  }
}

void TileReader::lay_out() {
  const MaxPyramid::Level& level = *level_;
  const std::uint32_t run_length = run_length_of(level);
  const int side = 1 << level.level;
  const std::size_t pitch = std::size_t{run_length} << static_cast<unsigned>(level.level);
  const int lowest_row = lowest_row_of(level);
  tiles_.resize(tile_count_);
  // The first row is all outside, as in the level.
  for (int row = lowest_row - 1; row <= level.highest_row; ++row) {
    const std::size_t out_row = static_cast<std::size_t>(row - lowest_row + 1) * pitch;
    std::array<const std::uint8_t*, kSide> in{};
    for (int line = 0; line < kTileSide; ++line) {
      const int from = row < lowest_row ? level.lowest_row - 1 : row + line * side;
      in[static_cast<std::size_t>(line)] = &level.data[level.row_offset(from)];
    }
    for (int run = 0; run < side; ++run) {
      const std::size_t first = static_cast<std::size_t>(run) * level.run_length +
                                MaxPyramid::kLanes - static_cast<std::size_t>(kTileSide);
      auto* const out = &tiles_[out_row + static_cast<std::size_t>(run) * run_length];
      for (std::size_t i = 0; i < run_length; ++i) {
        for (std::size_t line = 0; line < kSide; ++line) out[i][line] = in[line][first + i];
      }
    }
  }
  for (std::size_t i = 0; i < column_offsets_.size(); ++i) {
    const int column = first_column_ + static_cast<int>(i);
    const int lowest = level.lowest_index - kTileSide;
    const int index = std::clamp(column >> level.level, lowest, level.highest_index + 1);
    column_offsets_[i] = static_cast<std::uint32_t>(column & (side - 1)) * run_length +
                         static_cast<std::uint32_t>(index - lowest);
  }
  for (std::size_t i = 0; i < row_offsets_.size(); ++i) {
    const int row = first_row_ + static_cast<int>(i);
    const bool is_outside = row < lowest_row || row > level.highest_row;
    row_offsets_[i] =
        is_outside
            ? 0U
            : static_cast<std::uint32_t>(static_cast<std::size_t>(row - lowest_row + 1) * pitch);
  }
}

}  // namespace loopstone
