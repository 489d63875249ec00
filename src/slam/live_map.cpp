#include "loopstone/slam/live_map.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <span>

#include "loopstone/geometry/angle.hpp"
#include "slam/scan_store.hpp"

namespace loopstone {

namespace {

/// Submaps that move by less of a cell stay as they are drawn.
constexpr double kStillCells = 0.25;

std::vector<PosedScan> posed(std::span<const std::shared_ptr<const MappedScan>> scans,
                             const Pose2& map_T_local) {
  std::vector<PosedScan> all;
  all.reserve(scans.size());
  for (const auto& mapped : scans) all.push_back(loopstone::posed(*mapped, map_T_local));
  return all;
}

/// Where the robot stood at the last scan of a submap.
std::optional<Eigen::Vector2d> last_position(const MappedScans& scans, std::size_t count,
                                             const Pose2& map_T_local) {
  if (count == 0) return {};
  return (map_T_local * scans[count - 1]->local_T_robot).translation();
}

bool intersect(const std::vector<TileId>& a, const std::set<TileId>& b) {
  return std::ranges::any_of(a, [&](TileId id) { return b.contains(id); });
}

}  // namespace

LiveMap::LiveMap(const OccupancyOptions& options, double footprint_radius_m)
    : tiles_(options, footprint_radius_m) {}

/// Whether what is drawn of a submap is not what it is now: thinned, moved, or come to from
/// elsewhere.
bool LiveMap::is_stale(const Drawn& drawn, const SubmapSnapshot& submap,
                       const std::optional<Eigen::Vector2d>& before) const {
  if (submap.scans->size() < drawn.count) return true;
  const double still_m = kStillCells * tiles_.resolution_m();
  if (before.has_value() != drawn.before.has_value()) return true;
  if (before && (*before - *drawn.before).norm() > still_m) return true;
  const Pose2 change = drawn.map_T_local.inverse() * submap.map_T_local;
  // Where its first scan was taken, and what its farthest cell swings about that.
  const Eigen::Vector2d at = drawn.scans->front()->local_T_robot.translation();
  const Eigen::Vector2d shift = (submap.map_T_local * at).eval() - (drawn.map_T_local * at).eval();
  const double swing_m = 2.0 * std::abs(std::sin(0.5 * wrap_angle(change.yaw))) * drawn.reach_m;
  return shift.norm() + swing_m > still_m;
}

void LiveMap::note_tiles(Drawn& drawn, const std::vector<TileId>& tiles) const {
  std::vector<TileId> all;
  std::ranges::set_union(drawn.tiles, tiles, std::back_inserter(all));
  drawn.tiles = std::move(all);
  const double side_m = OccupancyTile::kSide * tiles_.resolution_m();
  const Eigen::Vector2d from =
      (drawn.map_T_local * drawn.scans->front()->local_T_robot).translation();
  for (const TileId id : tiles) {
    const Eigen::Vector2d middle((id.column + 0.5) * side_m, (id.row + 0.5) * side_m);
    drawn.reach_m = std::max(drawn.reach_m, (middle - from).norm() + side_m);
  }
}

std::size_t LiveMap::refresh(const MapSnapshot& snapshot) {
  using Where = OccupancyTiles::DrawWhere;
  std::set<TileId> dirty;
  std::optional<Eigen::Vector2d> before;
  for (std::size_t i = 0; i < std::min(drawn_.size(), snapshot.submaps.size()); ++i) {
    const SubmapSnapshot& submap = snapshot.submaps[i];
    Drawn& drawn = drawn_[i];
    if (is_stale(drawn, submap, before)) {
      dirty.insert(drawn.tiles.begin(), drawn.tiles.end());
      drawn = {.map_T_local = submap.map_T_local,
               .scans = submap.scans,
               .count = submap.scans->size(),
               .before = before};
      const auto tiles = tiles_.tiles_of(posed(*drawn.scans, drawn.map_T_local), before);
      note_tiles(drawn, tiles);
      dirty.insert(tiles.begin(), tiles.end());
    }
    before = last_position(*drawn.scans, drawn.count, drawn.map_T_local);
  }
  tiles_.erase(std::vector<TileId>(dirty.begin(), dirty.end()));

  before.reset();
  for (std::size_t i = 0; i < snapshot.submaps.size(); ++i) {
    const SubmapSnapshot& submap = snapshot.submaps[i];
    if (i == drawn_.size()) drawn_.push_back({.map_T_local = submap.map_T_local, .before = before});
    Drawn& drawn = drawn_[i];
    drawn.scans = submap.scans;
    const std::span scans(*submap.scans);
    if (intersect(drawn.tiles, dirty))
      tiles_.draw(posed(scans.first(drawn.count), drawn.map_T_local), Where::kErased, before);
    if (drawn.count > 0) before = last_position(*drawn.scans, drawn.count, drawn.map_T_local);
    if (scans.size() > drawn.count) {
      const auto fresh = posed(scans.subspan(drawn.count), drawn.map_T_local);
      note_tiles(drawn, tiles_.draw(fresh, Where::kAnywhere, before));
      drawn.count = scans.size();
      before = last_position(*drawn.scans, drawn.count, drawn.map_T_local);
    }
  }
  return tiles_.finish_drawing();
}

}  // namespace loopstone
