#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

/// Which tile of the plane: tile (0, 0) has its lower left corner at the origin of the map.
struct TileId {
  int column = 0;
  int row = 0;
  friend constexpr auto operator<=>(const TileId&, const TileId&) = default;
};

/// 64 x 64 cells of an occupancy map, row by row from the lower left one.
struct OccupancyTile {
  static constexpr int kSide = 64;
  static constexpr std::size_t kCells = std::size_t{kSide} * kSide;

  TileId id{};
  std::int64_t revision = 0;             ///< grows whenever the tile is drawn anew
  std::array<float, kCells> log_odds{};  ///< 0 where never observed
  std::array<std::uint8_t, kCells>
      observed{};  ///< 1 where a beam passed or ended, or the robot drove
};

/// An occupancy map that can be drawn anew in parts. Drawn in one go it is build_occupancy_map() of
/// the same scans, cell for cell.
///
///   tiles.erase(dirty);                                   // unknown again
///   tiles.draw(older_scans, DrawWhere::kErased, before);  // on the erased tiles only
///   tiles.draw(newer_scans, DrawWhere::kAnywhere, before);
///   tiles.finish_drawing();                               // what was changed has a new revision
///
/// Scans are drawn in the order of the recording. Memory: 21 kB a tile that was observed.
class OccupancyTiles {
 public:
  enum class DrawWhere { kAnywhere, kErased };

  OccupancyTiles(const OccupancyOptions& options, double footprint_radius_m);
  ~OccupancyTiles();
  OccupancyTiles(OccupancyTiles&&) noexcept;
  OccupancyTiles& operator=(OccupancyTiles&&) noexcept;

  /// The tiles that scans would change, in order.
  /// \param before  where the robot stood at the scan before, map frame
  [[nodiscard]] std::vector<TileId> tiles_of(std::span<const PosedScan> scans,
                                             const std::optional<Eigen::Vector2d>& before) const;
  void erase(std::span<const TileId> ids);
  /// Returns the tiles that were drawn on, in order.
  std::vector<TileId> draw(std::span<const PosedScan> scans, DrawWhere where,
                           const std::optional<Eigen::Vector2d>& before);
  /// The tiles of another map of the same kind take the places of those with their ids.
  void replace_by(OccupancyTiles&& others);
  /// Returns how many tiles were changed.
  std::size_t finish_drawing();

  /// Of the last finish_drawing(); 0 before the first.
  [[nodiscard]] std::int64_t revision() const { return revision_; }
  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  /// The tiles whose revision is larger, in order.
  [[nodiscard]] std::vector<OccupancyTile> tiles_since(std::int64_t revision) const;
  /// All tiles as one map, as small as it can be; one unknown cell where nothing was observed.
  [[nodiscard]] OccupancyMap whole() const;

 private:
  struct Tile;
  class Pen;

  [[nodiscard]] OccupancyTile shown(TileId id, const Tile& tile) const;

  OccupancyOptions options_;
  double footprint_radius_m_;
  double resolution_m_;
  std::map<TileId, std::unique_ptr<Tile>> tiles_;
  std::int64_t revision_ = 0;
};

}  // namespace loopstone
