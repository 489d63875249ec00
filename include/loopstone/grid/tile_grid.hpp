#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

/// A grid without edges for large maps: memory only for the 64 x 64 tiles that were written to, and
/// no tile ever moves. Cell (0, 0) has its lower left corner at the origin of the plane; cells may
/// be negative. For maps that are small or read at random BlockGrid is faster.
template <typename T>
class TileGrid {
 public:
  static constexpr int kTileBits = 6;
  static constexpr int kTileSide = 1 << kTileBits;
  static constexpr int kTileMask = kTileSide - 1;
  /// Row-major from the lower left cell.
  using Tile = std::array<T, static_cast<std::size_t>(kTileSide) * kTileSide>;

  explicit TileGrid(double resolution_m = 0.01) : resolution_m_(resolution_m) {}

  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  [[nodiscard]] std::size_t tile_count() const { return tiles_.size(); }
  [[nodiscard]] bool empty() const { return tiles_.empty(); }
  [[nodiscard]] std::size_t memory_bytes() const { return tiles_.size() * sizeof(Tile); }

  [[nodiscard]] static Cell tile_of(Cell cell) {
    return {cell.column >> kTileBits, cell.row >> kTileBits};
  }
  [[nodiscard]] static std::size_t offset_in_tile(Cell cell) {
    return static_cast<std::size_t>(cell.row & kTileMask) * kTileSide +
           static_cast<std::size_t>(cell.column & kTileMask);
  }
  [[nodiscard]] Eigen::Vector2d centre_of(Cell cell) const {
    return {(cell.column + 0.5) * resolution_m_, (cell.row + 0.5) * resolution_m_};
  }
  [[nodiscard]] Cell cell_of(const Eigen::Vector2d& point) const {
    return {floor_to_int(point.x() / resolution_m_), floor_to_int(point.y() / resolution_m_)};
  }

  /// nullptr where nothing was ever written.
  [[nodiscard]] const Tile* find_tile(Cell tile) const {
    const auto found = tiles_.find(key_of(tile));
    return found == tiles_.end() ? nullptr : found->second.get();
  }
  [[nodiscard]] Tile* find_tile(Cell tile) {
    const auto found = tiles_.find(key_of(tile));
    return found == tiles_.end() ? nullptr : found->second.get();
  }
  /// Made if need be, all cells T{}.
  [[nodiscard]] Tile& tile(Cell tile) {
    std::unique_ptr<Tile>& found = tiles_[key_of(tile)];
    if (!found) found = std::make_unique<Tile>();
    return *found;
  }
  [[nodiscard]] const T* find(Cell cell) const {
    const Tile* tile = find_tile(tile_of(cell));
    return tile == nullptr ? nullptr : &(*tile)[offset_in_tile(cell)];
  }
  [[nodiscard]] T& at(Cell cell) { return tile(tile_of(cell))[offset_in_tile(cell)]; }

  /// The tiles that exist, by row, then by column.
  [[nodiscard]] std::vector<Cell> tiles() const {
    std::vector<Cell> cells;
    cells.reserve(tiles_.size());
    for (const auto& entry : tiles_) cells.push_back(tile_of_key(entry.first));
    std::sort(cells.begin(), cells.end(),
              [](Cell a, Cell b) { return a.row != b.row ? a.row < b.row : a.column < b.column; });
    return cells;
  }

  void erase_tile(Cell tile) { tiles_.erase(key_of(tile)); }

 private:
  [[nodiscard]] static std::uint64_t key_of(Cell tile) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(tile.row)) << 32U) |
           static_cast<std::uint32_t>(tile.column);
  }
  [[nodiscard]] static Cell tile_of_key(std::uint64_t key) {
    return {static_cast<int>(static_cast<std::uint32_t>(key)),
            static_cast<int>(static_cast<std::uint32_t>(key >> 32U))};
  }

  double resolution_m_;
  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_{};
};

}  // namespace loopstone
