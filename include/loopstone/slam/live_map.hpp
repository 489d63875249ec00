#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/mapping/occupancy_tiles.hpp"
#include "loopstone/slam/map_snapshot.hpp"

namespace loopstone {

/// The occupancy map of a robot that still drives: all scans so far, each with its submap, at the
/// poses that submaps have now.
///
///   LiveMap live(options.map, robot.footprint_radius_m);
///   live.refresh(mapper.snapshot());                       // whenever it is wanted, on any thread
///   for (const OccupancyTile& tile : live.tiles_since(shown)) show(tile);
///   shown = live.revision();
///
/// Where nothing moved, only new scans are drawn; where a submap moved, the tiles that it touched
/// before and after are drawn anew from all scans that touch them. A submap that moves its farthest
/// cell by less than a quarter of a cell has not moved.
///
/// Against the finished map: the same scans, drawn by the same rule. The finished map bends submaps
/// to share out what closes loops, and moves key scans onto common surfaces: docs/accuracy.md says
/// how far both are apart.
/// Cost: that of drawing the new scans, 20 us each at 180 beams; after a closure, of all scans of
/// what moved. Memory: 21 kB a tile that was observed. Not thread-safe; one thread at a time.
class LiveMap {
 public:
  LiveMap(const OccupancyOptions& options, double footprint_radius_m);

  /// Snapshots of one mapper, in their order. Returns how many tiles were drawn on.
  std::size_t refresh(const MapSnapshot& snapshot);

  /// Of the last refresh(); 0 before the first.
  [[nodiscard]] std::int64_t revision() const { return tiles_.revision(); }
  /// The tiles that were drawn on after that revision, in order of their ids.
  [[nodiscard]] std::vector<OccupancyTile> tiles_since(std::int64_t revision) const {
    return tiles_.tiles_since(revision);
  }
  [[nodiscard]] double resolution_m() const { return tiles_.resolution_m(); }
  /// All of it as one map.
  [[nodiscard]] OccupancyMap map() const { return tiles_.whole(); }

 private:
  /// A submap as it is on the tiles.
  struct Drawn {
    Pose2 map_T_local{};
    std::shared_ptr<const MappedScans> scans{};
    std::size_t count = 0;                    ///< of its scans
    std::optional<Eigen::Vector2d> before{};  ///< where the robot came from
    std::vector<TileId> tiles{};
    double reach_m = 0.0;  ///< from the middle of the scans to the farthest corner of a tile
  };

  [[nodiscard]] bool is_stale(const Drawn& drawn, const SubmapSnapshot& submap,
                              const std::optional<Eigen::Vector2d>& before) const;
  void note_tiles(Drawn& drawn, const std::vector<TileId>& tiles) const;

  OccupancyTiles tiles_;
  std::vector<Drawn> drawn_{};
};

}  // namespace loopstone
