#include "loopstone/slam/live_map.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "slam/posed_scan.hpp"

namespace loopstone {

namespace {

using Where = OccupancyTiles::DrawWhere;

/// Submaps that move by less of a cell stay as they are drawn.
constexpr double kStillCells = 0.25;

Eigen::Vector2d position_at(const MappedScan& scan, const Pose2& map_T_local) {
  return (map_T_local * scan.local_T_robot).translation();
}

/// Where the robot stood at the last scan before a submap.
std::optional<Eigen::Vector2d> position_before(const MapSnapshot& snapshot, std::size_t submap) {
  while (submap-- > 0) {
    const SubmapSnapshot& earlier = snapshot.submaps[submap];
    if (!earlier.scans->empty()) return position_at(*earlier.scans->back(), earlier.map_T_local);
  }
  return {};
}

bool intersect(const std::vector<TileId>& a, const std::set<TileId>& b) {
  return std::ranges::any_of(a, [&](TileId id) { return b.contains(id); });
}

/// Some scans of a submap, and where the robot stood before them.
struct Stretch {
  std::vector<PosedScan> scans{};
  std::optional<Eigen::Vector2d> before{};
};

template <typename Drawn>
Stretch stretch_of(const Drawn& drawn, std::size_t first, std::size_t count) {
  Stretch stretch;
  stretch.scans.reserve(count);
  for (std::size_t i = first; i < first + count; ++i)
    stretch.scans.push_back(posed(*(*drawn.scans)[i], drawn.map_T_local));
  stretch.before = first == 0
                       ? drawn.before
                       : std::optional(position_at(*(*drawn.scans)[first - 1], drawn.map_T_local));
  return stretch;
}

/// As much of what remains as the limit allows; takes it off the limit.
std::size_t take(std::size_t remaining, std::size_t& scans_left) {
  const std::size_t taken = std::min(remaining, scans_left);
  scans_left -= taken;
  return taken;
}

}  // namespace

LiveMap::LiveMap(const OccupancyOptions& options, double footprint_radius_m)
    : options_(options),
      footprint_radius_m_(footprint_radius_m),
      tiles_(options, footprint_radius_m) {}

/// Whether what is drawn of a submap is not what it is now: thinned, moved, or come to from
/// elsewhere.
bool LiveMap::is_stale(const MapSnapshot& snapshot, std::size_t index) const {
  const SubmapSnapshot& submap = snapshot.submaps[index];
  const Drawn& drawn = drawn_[index];
  if (drawn.count == 0) return false;
  if (submap.scans->size() < drawn.count) return true;
  const double still_m = kStillCells * tiles_.resolution_m();
  const auto before = position_before(snapshot, index);
  if (before.has_value() != drawn.before.has_value()) return true;
  if (before && (*before - *drawn.before).norm() > still_m) return true;
  const Pose2 change = drawn.map_T_local.inverse() * submap.map_T_local;
  // Where its first scan was taken, and what its farthest cell swings about that.
  const Eigen::Vector2d at = drawn.scans->front()->local_T_robot.translation();
  const Eigen::Vector2d shift = (submap.map_T_local * at).eval() - (drawn.map_T_local * at).eval();
  const double swing_m = 2.0 * std::abs(std::sin(0.5 * wrap_angle(change.yaw))) * drawn.reach_m;
  return shift.norm() + swing_m > still_m;
}

bool LiveMap::waits(const MapSnapshot& snapshot, std::size_t index) const {
  return index >= drawn_.size() || drawn_[index].count < snapshot.submaps[index].scans->size() ||
         is_stale(snapshot, index) ||
         (redraw_ && std::ranges::binary_search(redraw_->moved, index));
}

void LiveMap::note_tiles(Drawn& drawn, const std::vector<TileId>& tiles) const {
  std::vector<TileId> all;
  std::ranges::set_union(drawn.tiles, tiles, std::back_inserter(all));
  drawn.tiles = std::move(all);
  const double side_m = OccupancyTile::kSide * tiles_.resolution_m();
  const Eigen::Vector2d from = position_at(*drawn.scans->front(), drawn.map_T_local);
  for (const TileId id : tiles) {
    const Eigen::Vector2d middle((id.column + 0.5) * side_m, (id.row + 0.5) * side_m);
    drawn.reach_m = std::max(drawn.reach_m, (middle - from).norm() + side_m);
  }
}

/// How many scans were never drawn.
std::size_t LiveMap::new_scans(const MapSnapshot& snapshot) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < snapshot.submaps.size(); ++i) {
    const std::size_t size = snapshot.submaps[i].scans->size();
    const std::size_t drawn = i < drawn_.size() ? drawn_[i].count : 0;
    count += size - std::min(size, drawn);
  }
  return count;
}

void LiveMap::draw_new_scans(const MapSnapshot& snapshot, std::size_t most_scans) {
  for (std::size_t i = 0; i < snapshot.submaps.size() && most_scans > 0; ++i) {
    const SubmapSnapshot& submap = snapshot.submaps[i];
    if (i == drawn_.size()) drawn_.emplace_back();
    Drawn& drawn = drawn_[i];
    if (drawn.count == 0) {
      drawn.map_T_local = submap.map_T_local;
      drawn.before = position_before(snapshot, i);
    }
    if (submap.scans->size() < drawn.count) continue;  // it waits to be drawn anew
    drawn.scans = submap.scans;
    const std::size_t count = take(submap.scans->size() - drawn.count, most_scans);
    if (count == 0) continue;
    const Stretch stretch = stretch_of(drawn, drawn.count, count);
    drawn.count += count;
    note_tiles(drawn, tiles_.draw(stretch.scans, Where::kAnywhere, stretch.before));
  }
}

bool LiveMap::begin_redraw(const MapSnapshot& snapshot, std::size_t most_scans) {
  struct Candidate {
    std::size_t submap = 0;
    double distance_m = 0.0;
  };
  std::vector<Candidate> stale;
  const auto robot = position_before(snapshot, snapshot.submaps.size());
  for (std::size_t i = std::min(drawn_.size(), snapshot.submaps.size()); i-- > 0;) {
    if (!is_stale(snapshot, i)) continue;
    const SubmapSnapshot& submap = snapshot.submaps[i];
    stale.push_back({i, (position_at(*submap.scans->front(), submap.map_T_local) - *robot).norm()});
  }
  if (stale.empty()) return false;
  // The newest of those that are equally near.
  std::ranges::stable_sort(stale, {}, &Candidate::distance_m);

  Redraw redraw{.tiles = OccupancyTiles(options_, footprint_radius_m_)};
  for (const Candidate& candidate : stale) {
    const SubmapSnapshot& submap = snapshot.submaps[candidate.submap];
    Drawn& drawn = drawn_[candidate.submap];
    const std::size_t count = std::min(drawn.count, submap.scans->size());
    if (!redraw.moved.empty() && count > most_scans) break;
    most_scans -= std::min(count, most_scans);
    redraw.moved.push_back(candidate.submap);
    redraw.touched.insert(drawn.tiles.begin(), drawn.tiles.end());
    drawn = {.map_T_local = submap.map_T_local,
             .scans = submap.scans,
             .count = count,
             .before = position_before(snapshot, candidate.submap)};
  }
  std::ranges::sort(redraw.moved);
  redraw_ = std::move(redraw);
  return true;
}

/// Which tiles the moved submaps touch now.
void LiveMap::measure(Redraw& redraw, std::size_t& scans_left) {
  while (redraw.measured < redraw.moved.size() && scans_left > 0) {
    Drawn& drawn = drawn_[redraw.moved[redraw.measured]];
    const std::size_t count = take(drawn.count - redraw.scan, scans_left);
    const Stretch stretch = stretch_of(drawn, redraw.scan, count);
    const auto tiles = tiles_.tiles_of(stretch.scans, stretch.before);
    note_tiles(drawn, tiles);
    redraw.touched.insert(tiles.begin(), tiles.end());
    redraw.scan += count;
    if (redraw.scan < drawn.count) return;
    redraw.scan = 0;
    if (++redraw.measured < redraw.moved.size()) continue;
    redraw.tiles.erase(std::vector<TileId>(redraw.touched.begin(), redraw.touched.end()));
  }
}

/// All scans that touch those tiles, in the order of the recording.
void LiveMap::draw_beside(Redraw& redraw, std::size_t& scans_left) {
  while (redraw.submap < drawn_.size()) {
    const Drawn& drawn = drawn_[redraw.submap];
    if (redraw.scan > 0 || intersect(drawn.tiles, redraw.touched)) {
      const std::size_t count = take(drawn.count - redraw.scan, scans_left);
      const Stretch stretch = stretch_of(drawn, redraw.scan, count);
      (void)redraw.tiles.draw(stretch.scans, Where::kErased, stretch.before);
      redraw.scan += count;
      if (redraw.scan < drawn.count) return;
    }
    redraw.scan = 0;
    ++redraw.submap;
  }
}

void LiveMap::go_on_redrawing(std::size_t& scans_left) {
  measure(*redraw_, scans_left);
  if (redraw_->measured < redraw_->moved.size()) return;
  draw_beside(*redraw_, scans_left);
  if (redraw_->submap < drawn_.size()) return;
  tiles_.replace_by(std::move(redraw_->tiles));
  redraw_.reset();
}

std::size_t LiveMap::refresh(const MapSnapshot& snapshot, std::size_t most_scans) {
  std::size_t scans_left = std::max<std::size_t>(most_scans, 1);
  // Neither new scans nor what moved waits for the other.
  const std::size_t for_new_scans = std::min(new_scans(snapshot), scans_left / 2);
  scans_left -= for_new_scans;
  while (scans_left > 0 && (redraw_ || begin_redraw(snapshot, most_scans)))
    go_on_redrawing(scans_left);
  draw_new_scans(snapshot, for_new_scans + scans_left);
  submaps_waiting_ = 0;
  for (std::size_t i = 0; i < snapshot.submaps.size(); ++i)
    submaps_waiting_ += waits(snapshot, i) ? 1 : 0;
  return tiles_.finish_drawing();
}

}  // namespace loopstone
