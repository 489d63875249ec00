#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <set>
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
/// A closure may move all submaps at once. What one refresh() draws is limited, and it goes on
/// where the last one ended: first the submaps nearest to the robot, some at a time. Their tiles
/// are drawn beside those that are shown, which give way when all is drawn: until then a submap is
/// seen where it was, and new scans at their new place. What is drawn when depends on the snapshots
/// and limits alone, not on time. Calls with one snapshot end with the tiles that one call without
/// a limit would have made.
///
/// Against the finished map: the same scans, drawn by the same rule. The finished map bends submaps
/// to share out what closes loops, and moves key scans onto common surfaces: docs/accuracy.md says
/// how far both are apart.
/// Cost: 20 us for each scan of 180 beams that is drawn. Memory: 21 kB a tile that was observed,
/// and as much for each that is being drawn anew. Not thread-safe; one thread at a time.
class LiveMap {
 public:
  /// What one refresh() draws at most unless told otherwise: about 0.1 s.
  static constexpr std::size_t kMostScans = 4000;
  static constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

  LiveMap(const OccupancyOptions& options, double footprint_radius_m);

  /// Snapshots of one mapper, in their order. Returns how many tiles were changed.
  /// \param most_scans  that are drawn, or looked at for the tiles that they touch; at least 1. New
  ///                    scans and those to be drawn anew share it when both wait.
  std::size_t refresh(const MapSnapshot& snapshot, std::size_t most_scans = kMostScans);

  /// Whether the tiles show all of the last snapshot; true before the first.
  [[nodiscard]] bool is_current() const { return submaps_waiting_ == 0; }
  /// How many submaps of the last snapshot are shown where they no longer are, or not with all of
  /// their scans.
  [[nodiscard]] std::size_t submaps_waiting() const { return submaps_waiting_; }

  /// Of the last refresh(); 0 before the first.
  [[nodiscard]] std::int64_t revision() const { return tiles_.revision(); }
  /// The tiles that were changed after that revision, in order of their ids.
  [[nodiscard]] std::vector<OccupancyTile> tiles_since(std::int64_t revision) const {
    return tiles_.tiles_since(revision);
  }
  [[nodiscard]] double resolution_m() const { return tiles_.resolution_m(); }
  /// All of it as one map.
  [[nodiscard]] OccupancyMap map() const { return tiles_.whole(); }

 private:
  /// A submap as it is on the tiles, or will be when its redrawing is done.
  struct Drawn {
    Pose2 map_T_local{};
    std::shared_ptr<const MappedScans> scans{};
    std::size_t count = 0;                    ///< of its scans
    std::optional<Eigen::Vector2d> before{};  ///< where the robot came from
    std::vector<TileId> tiles{};
    double reach_m = 0.0;  ///< from the middle of the scans to the farthest corner of a tile
  };
  /// Submaps that moved, on their way to the tiles.
  struct Redraw {
    OccupancyTiles tiles;              ///< to take the place of those that are shown
    std::vector<std::size_t> moved{};  ///< indices of submaps, in order
    std::set<TileId> touched{};        ///< by them, before and after
    std::size_t measured = 0;          ///< of `moved`: what they touch is known
    std::size_t submap = 0;            ///< the next to be drawn, of all
    std::size_t scan = 0;              ///< the next of the submap that is measured or drawn
  };

  [[nodiscard]] bool is_stale(const MapSnapshot& snapshot, std::size_t index) const;
  [[nodiscard]] bool waits(const MapSnapshot& snapshot, std::size_t index) const;
  void note_tiles(Drawn& drawn, const std::vector<TileId>& tiles) const;
  [[nodiscard]] std::size_t new_scans(const MapSnapshot& snapshot) const;
  void draw_new_scans(const MapSnapshot& snapshot, std::size_t most_scans);
  /// Of the submaps that moved, those nearest to the robot, together about so many scans. False
  /// when there are none.
  bool begin_redraw(const MapSnapshot& snapshot, std::size_t most_scans);
  /// Takes what is drawn off `scans_left`.
  void go_on_redrawing(std::size_t& scans_left);
  void measure(Redraw& redraw, std::size_t& scans_left);
  void draw_beside(Redraw& redraw, std::size_t& scans_left);

  OccupancyOptions options_;
  double footprint_radius_m_;
  OccupancyTiles tiles_;
  std::vector<Drawn> drawn_{};
  std::optional<Redraw> redraw_{};
  std::size_t submaps_waiting_ = 0;
};

}  // namespace loopstone
