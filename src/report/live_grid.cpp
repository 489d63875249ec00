#include "report/live_grid.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace loopstone {
namespace {

constexpr int kSide = OccupancyTile::kSide;

std::uint64_t tiles_between(int low, int high) {
  return static_cast<std::uint64_t>(std::int64_t{high} - low + 1);
}

}  // namespace

bool LiveGrid::update(const LiveMap& live) {
  if (is_too_large_ || live.revision() == shown_) return false;
  const std::vector<OccupancyTile> changed = live.tiles_since(shown_);
  shown_ = live.revision();
  if (changed.empty()) return false;
  TileId low = cells_.empty() ? changed.front().id : low_;
  TileId high = cells_.empty() ? changed.front().id : high_;
  for (const OccupancyTile& tile : changed) {
    low = {std::min(low.column, tile.id.column), std::min(low.row, tile.id.row)};
    high = {std::max(high.column, tile.id.column), std::max(high.row, tile.id.row)};
  }
  if (!grow_to(low, high, live.resolution_m())) {
    is_too_large_ = true;
    cells_ = {};
    return false;
  }
  for (const OccupancyTile& tile : changed) show(tile);
  return true;
}

bool LiveGrid::grow_to(TileId low, TileId high, double resolution_m) {
  if (!cells_.empty() && low == low_ && high == high_) return true;
  const std::uint64_t columns = tiles_between(low.column, high.column);
  const std::uint64_t rows = tiles_between(low.row, high.row);
  // Compared without a product that might not fit.
  if (columns > most_cells_ / OccupancyTile::kCells / rows) return false;
  const double tile_m = kSide * resolution_m;
  const GridFrame frame{.origin = {low.column * tile_m, low.row * tile_m},
                        .resolution = resolution_m,
                        .columns = static_cast<int>(columns) * kSide,
                        .rows = static_cast<int>(rows) * kSide};
  CellStates grown(frame, kUnknownCell);
  const GridFrame& old = cells_.frame();
  const Cell corner{(low_.column - low.column) * kSide, (low_.row - low.row) * kSide};
  for (int row = 0; row < old.rows; ++row) {
    const auto* from = cells_.cells().data() + old.index_of({0, row});
    std::copy_n(from, old.columns,
                grown.cells().data() + frame.index_of({corner.column, corner.row + row}));
  }
  cells_ = std::move(grown);
  low_ = low;
  high_ = high;
  return true;
}

void LiveGrid::show(const OccupancyTile& tile) {
  const GridFrame frame{.resolution = cells_.frame().resolution, .columns = kSide, .rows = kSide};
  OccupancyMap map{Grid<float>(frame), Grid<std::uint8_t>(frame)};
  std::ranges::copy(tile.log_odds, map.log_odds.cells().begin());
  std::ranges::copy(tile.observed, map.observed.cells().begin());
  const CellStates states = cell_states(map);
  const Cell corner{(tile.id.column - low_.column) * kSide, (tile.id.row - low_.row) * kSide};
  for (int row = 0; row < kSide; ++row) {
    const auto* from = states.cells().data() + frame.index_of({0, row});
    std::copy_n(from, kSide,
                cells_.cells().data() + cells_.frame().index_of({corner.column, corner.row + row}));
  }
}

}  // namespace loopstone
