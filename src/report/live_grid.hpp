#pragma once

#include <cstdint>
#include <optional>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/slam/live_map.hpp"

namespace loopstone {

/// A live map as the cells of an occupancy grid, which grows by whole tiles. Only tiles that
/// changed are looked at.
class LiveGrid {
 public:
  /// \param most_cells  a larger map is not shown
  explicit LiveGrid(std::uint64_t most_cells) : most_cells_(most_cells) {}

  /// What changed since the call before. Returns whether cells() are others than before; never
  /// again once the map is too large.
  bool update(const LiveMap& live);
  [[nodiscard]] const CellStates& cells() const { return cells_; }

 private:
  /// False when that is too large.
  [[nodiscard]] bool grow_to(TileId low, TileId high, double resolution_m);
  void show(const OccupancyTile& tile);

  std::uint64_t most_cells_;
  bool is_too_large_ = false;
  std::int64_t shown_ = 0;
  TileId low_{};  ///< of the grid's tiles
  TileId high_{};
  CellStates cells_{};
};

}  // namespace loopstone
