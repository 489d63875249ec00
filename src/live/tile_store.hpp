#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/mapping/occupancy_tiles.hpp"
#include "loopstone/messages/message_types.hpp"

namespace loopstone {

/// All tiles of a map as viewers show them, a byte a cell: for whoever comes late.
class TileStore {
 public:
  /// Nothing is there any more.
  void clear(double resolution_m);
  /// Puts tiles in place, and tells of them. Those that were so already are left out.
  [[nodiscard]] msg::MapTiles change(std::span<const OccupancyTile> tiles);
  /// In place of all tiles that there were the cells of a map, which need not be whole tiles.
  /// Where its grid is not that of the tiles it is moved by half a cell at most.
  void replace(const CellStates& cells);
  /// Likewise with the cells' belief.
  void replace(const OccupancyMap& map);

  [[nodiscard]] msg::MapTiles whole() const;
  [[nodiscard]] double known_m2() const;
  [[nodiscard]] bool empty() const { return tiles_.empty(); }

 private:
  using Tile = std::vector<std::uint8_t>;

  template <typename ByteOf>
  void replace(const GridFrame& frame, const ByteOf& byte_of);
  [[nodiscard]] msg::MapTiles empty_message() const;
  void put(TileId id, Tile tile);

  double resolution_m_ = 0.05;
  std::map<TileId, Tile> tiles_{};
  std::size_t known_cells_ = 0;
};

}  // namespace loopstone
