#include "loopstone/mapping/occupancy_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <utility>

#include "mapping/scan_drawing.hpp"

namespace loopstone {

namespace {

/// Half a side of the plane in cells, a multiple of a tile: 13 km of cells of 5 cm. What lies
/// beyond is left out.
constexpr int kHalfSide = 1 << 18;
static_assert(kHalfSide % OccupancyTile::kSide == 0);
static_assert(OccupancyTile::kSide == ScanRaster::kWordBits, "a word is a row of a tile");

GridFrame plane_of(double resolution_m) {
  const double low_m = -kHalfSide * resolution_m;
  return {.origin = {low_m, low_m},
          .resolution = resolution_m,
          .columns = 2 * kHalfSide,
          .rows = 2 * kHalfSide};
}

TileId tile_of(int column, int row) {
  constexpr int kHalfTiles = kHalfSide / OccupancyTile::kSide;
  return {column / OccupancyTile::kSide - kHalfTiles, row / OccupancyTile::kSide - kHalfTiles};
}

bool on_plane(const PosedScan& posed, const GridFrame& plane) {
  // No beam is longer than this.
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(1000.0);
  return usable(posed) && plane.contains(plane.cell_of(posed.map_T_lidar.translation() - reach)) &&
         plane.contains(plane.cell_of(posed.map_T_lidar.translation() + reach));
}

}  // namespace

struct OccupancyTiles::Tile {
  std::array<float, OccupancyTile::kCells> log_odds{};
  std::array<std::uint8_t, OccupancyTile::kCells> observed{};
  std::array<std::uint64_t, OccupancyTile::kSide> driven{};  ///< a bit a cell, a word a row
  std::int64_t revision = 0;
  bool erased = false;   ///< since the last finish_drawing()
  bool changed = false;  ///< likewise
};

/// Goes over the cells that scans change.
class OccupancyTiles::Pen {
 public:
  Pen(const OccupancyOptions& options, double resolution_m, double footprint_radius_m)
      : options_(options), plane_(plane_of(resolution_m)), radius_m_(footprint_radius_m) {}

  /// \param on_word    (row of the plane, column of bit 0, passed bits, hit bits)
  /// \param on_driven  (Cell of the plane)
  template <typename OnWord, typename OnDriven>
  void go(std::span<const PosedScan> scans, std::optional<Eigen::Vector2d> before, OnWord&& on_word,
          OnDriven&& on_driven) {
    for (const PosedScan& posed : scans) {
      if (!on_plane(posed, plane_)) continue;
      const ScanBeams beams = beams_on_grid(posed, plane_, options_, table_);
      if (!beams.beams.empty())
        raster_scan(beams, beams.low.row, beams.high.row + 1, raster_, on_word);
      sweep_footprint(plane_, posed.map_T_robot.translation(), radius_m_, before, on_driven);
    }
  }

 private:
  OccupancyOptions options_;
  GridFrame plane_;
  double radius_m_;
  BeamTable table_{};
  ScanRaster raster_{};
};

OccupancyTiles::OccupancyTiles(const OccupancyOptions& options, double footprint_radius_m)
    : options_(options),
      footprint_radius_m_(footprint_radius_m),
      resolution_m_(options.resolution_m) {}
OccupancyTiles::~OccupancyTiles() = default;
OccupancyTiles::OccupancyTiles(OccupancyTiles&&) noexcept = default;
OccupancyTiles& OccupancyTiles::operator=(OccupancyTiles&&) noexcept = default;

std::vector<TileId> OccupancyTiles::tiles_of(std::span<const PosedScan> scans,
                                             const std::optional<Eigen::Vector2d>& before) const {
  std::set<TileId> touched;
  Pen pen(options_, resolution_m_, footprint_radius_m_);
  TileId last{};
  const auto touch = [&](TileId id) {
    if (!touched.empty() && id == last) return;
    last = id;
    touched.insert(id);
  };
  pen.go(
      scans, before,
      [&](int row, int column, std::uint64_t, std::uint64_t) { touch(tile_of(column, row)); },
      [&](Cell cell) { touch(tile_of(cell.column, cell.row)); });
  return {touched.begin(), touched.end()};
}

void OccupancyTiles::erase(std::span<const TileId> ids) {
  for (const TileId id : ids) {
    std::unique_ptr<Tile>& tile = tiles_[id];
    tile = std::make_unique<Tile>();
    tile->erased = tile->changed = true;
  }
}

std::vector<TileId> OccupancyTiles::draw(std::span<const PosedScan> scans, DrawWhere where,
                                         const std::optional<Eigen::Vector2d>& before) {
  std::set<TileId> drawn;
  const CellUpdates updates(options_);
  Pen pen(options_, resolution_m_, footprint_radius_m_);
  Tile* last = nullptr;
  TileId last_id{};
  const auto tile_at = [&](int column, int row) -> Tile* {
    const TileId id = tile_of(column, row);
    if (last != nullptr && id == last_id) return last;
    const auto found = tiles_.find(id);
    if (where == DrawWhere::kErased) {
      if (found == tiles_.end() || !found->second->erased) return nullptr;
      last = found->second.get();
    } else {
      auto& tile = found == tiles_.end() ? tiles_[id] : found->second;
      if (!tile) tile = std::make_unique<Tile>();
      tile->changed = true;
      last = tile.get();
    }
    last_id = id;
    drawn.insert(id);
    return last;
  };
  pen.go(
      scans, before,
      [&](int row, int column, std::uint64_t passed, std::uint64_t hit) {
        Tile* const tile = tile_at(column, row);
        if (tile == nullptr) return;
        const std::size_t first = static_cast<std::size_t>(row % OccupancyTile::kSide) *
                                  std::size_t{OccupancyTile::kSide};
        updates.apply(passed, hit, tile->log_odds.data() + first, tile->observed.data() + first);
      },
      [&](Cell cell) {
        Tile* const tile = tile_at(cell.column, cell.row);
        if (tile == nullptr) return;
        tile->driven[static_cast<std::size_t>(cell.row % OccupancyTile::kSide)] |=
            std::uint64_t{1} << static_cast<unsigned>(cell.column % OccupancyTile::kSide);
      });
  return {drawn.begin(), drawn.end()};
}

void OccupancyTiles::replace_by(OccupancyTiles&& others) {
  for (auto& [id, tile] : others.tiles_) {
    tile->erased = false;
    tile->changed = true;
    tiles_[id] = std::move(tile);
  }
  others.tiles_.clear();
}

std::size_t OccupancyTiles::finish_drawing() {
  ++revision_;
  std::size_t changed = 0;
  for (auto& [id, tile] : tiles_) {
    if (!tile->changed) continue;
    tile->revision = revision_;
    tile->changed = tile->erased = false;
    ++changed;
  }
  return changed;
}

/// Where the robot stood, nothing fixed can be.
OccupancyTile OccupancyTiles::shown(TileId id, const Tile& tile) const {
  OccupancyTile shown{
      .id = id, .revision = tile.revision, .log_odds = tile.log_odds, .observed = tile.observed};
  const float free = -log_odds_of(options_.clamp_probability);
  for (std::size_t i = 0; i < OccupancyTile::kCells; ++i) {
    const std::uint64_t row = tile.driven[i / OccupancyTile::kSide];
    if ((row >> (i % OccupancyTile::kSide) & 1U) == 0) continue;
    shown.log_odds[i] = std::min(shown.log_odds[i], free);
    shown.observed[i] = 1;
  }
  return shown;
}

std::vector<OccupancyTile> OccupancyTiles::tiles_since(std::int64_t revision) const {
  std::vector<OccupancyTile> newer;
  for (const auto& [id, tile] : tiles_) {
    if (tile->revision > revision) newer.push_back(shown(id, *tile));
  }
  return newer;
}

OccupancyMap OccupancyTiles::whole() const {
  const std::vector<OccupancyTile> tiles = tiles_since(0);
  Cell low{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  Cell high{std::numeric_limits<int>::min(), std::numeric_limits<int>::min()};
  const auto for_each_observed = [&](const auto& visit) {
    for (const OccupancyTile& tile : tiles) {
      for (std::size_t i = 0; i < OccupancyTile::kCells; ++i) {
        if (tile.observed[i] == 0) continue;
        const auto [row, column] = std::div(static_cast<int>(i), OccupancyTile::kSide);
        visit(Cell{tile.id.column * OccupancyTile::kSide + column,
                   tile.id.row * OccupancyTile::kSide + row},
              tile.log_odds[i]);
      }
    }
  };
  for_each_observed([&](Cell cell, float) {
    low = {std::min(low.column, cell.column), std::min(low.row, cell.row)};
    high = {std::max(high.column, cell.column), std::max(high.row, cell.row)};
  });
  GridFrame frame{.origin = {0.0, 0.0}, .resolution = resolution_m_, .columns = 1, .rows = 1};
  if (low.column <= high.column) {
    frame.origin = {low.column * resolution_m_, low.row * resolution_m_};
    frame.columns = high.column - low.column + 1;
    frame.rows = high.row - low.row + 1;
  }
  OccupancyMap map{Grid<float>(frame), Grid<std::uint8_t>(frame)};
  for_each_observed([&](Cell cell, float log_odds) {
    const Cell on_map{cell.column - low.column, cell.row - low.row};
    map.log_odds[on_map] = log_odds;
    map.observed[on_map] = 1;
  });
  return map;
}

}  // namespace loopstone
