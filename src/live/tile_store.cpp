#include "live/tile_store.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace loopstone {
namespace {

constexpr int kSide = OccupancyTile::kSide;

std::uint8_t percent_of(float log_odds) {
  return static_cast<std::uint8_t>(std::lround(100.0 / (1.0 + std::exp(-double{log_odds}))));
}

void append(msg::MapTiles& message, TileId id, std::span<const std::uint8_t> cells) {
  message.ids.push_back(id.column);
  message.ids.push_back(id.row);
  message.cells.insert(message.cells.end(), cells.begin(), cells.end());
}

std::size_t known_in(std::span<const std::uint8_t> cells) {
  return cells.size() -
         static_cast<std::size_t>(std::ranges::count(cells, msg::MapTiles::kUnknown));
}

int floor_divided(int value) { return (value >= 0 ? value : value - (kSide - 1)) / kSide; }

}  // namespace

void TileStore::clear(double resolution_m) {
  resolution_m_ = resolution_m;
  tiles_.clear();
  known_cells_ = 0;
}

msg::MapTiles TileStore::empty_message() const {
  return {.resolution = resolution_m_, .size = kSide};
}

void TileStore::put(TileId id, Tile tile) {
  Tile& place = tiles_[id];
  known_cells_ -= known_in(place);
  known_cells_ += known_in(tile);
  place = std::move(tile);
}

msg::MapTiles TileStore::change(std::span<const OccupancyTile> tiles) {
  msg::MapTiles message = empty_message();
  for (const OccupancyTile& tile : tiles) {
    Tile cells(OccupancyTile::kCells, msg::MapTiles::kUnknown);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (tile.observed[i] != 0) cells[i] = percent_of(tile.log_odds[i]);
    }
    const auto before = tiles_.find(tile.id);
    if (before != tiles_.end() && before->second == cells) continue;
    append(message, tile.id, cells);
    put(tile.id, std::move(cells));
  }
  return message;
}

template <typename ByteOf>
void TileStore::replace(const GridFrame& frame, const ByteOf& byte_of) {
  clear(frame.resolution);
  const auto first_column = static_cast<int>(std::lround(frame.origin.x() / frame.resolution));
  const auto first_row = static_cast<int>(std::lround(frame.origin.y() / frame.resolution));
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const std::uint8_t byte = byte_of(frame.index_of({column, row}));
      if (byte == msg::MapTiles::kUnknown) continue;
      const int x = first_column + column;
      const int y = first_row + row;
      Tile& tile = tiles_[{floor_divided(x), floor_divided(y)}];
      if (tile.empty()) tile.assign(OccupancyTile::kCells, msg::MapTiles::kUnknown);
      const int across = x - kSide * floor_divided(x);
      const int up = y - kSide * floor_divided(y);
      tile[static_cast<std::size_t>(up) * kSide + static_cast<std::size_t>(across)] = byte;
      ++known_cells_;
    }
  }
}

void TileStore::replace(const CellStates& cells) {
  replace(cells.frame(), [&](std::size_t i) {
    const std::int8_t state = cells.cells()[i];
    return state < 0 ? msg::MapTiles::kUnknown : static_cast<std::uint8_t>(state);
  });
}

void TileStore::replace(const OccupancyMap& map) {
  replace(map.log_odds.frame(), [&](std::size_t i) {
    return map.observed.cells()[i] == 0 ? msg::MapTiles::kUnknown
                                        : percent_of(map.log_odds.cells()[i]);
  });
}

msg::MapTiles TileStore::whole() const {
  msg::MapTiles message = empty_message();
  message.whole = true;
  message.cells.reserve(tiles_.size() * OccupancyTile::kCells);
  for (const auto& [id, cells] : tiles_) append(message, id, cells);
  return message;
}

double TileStore::known_m2() const {
  return static_cast<double>(known_cells_) * resolution_m_ * resolution_m_;
}

}  // namespace loopstone
