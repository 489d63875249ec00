#include "loopstone/slam/laser_cover.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "loopstone/slam/laser_check.hpp"

namespace loopstone {
namespace {

bool is_near(float range_m) { return range_m > 0.0F && range_m < kLaserCheck.cover_m; }

/// Whether a surface was seen here or beside.
bool has_surface(const Submap& submap, const Eigen::Vector2d& point) {
  const auto& surfaces = submap.state().thin_surfaces;
  const Cell middle = surfaces.cell_of(point.x(), point.y());
  for (int row = middle.row - 1; row <= middle.row + 1; ++row) {
    for (int column = middle.column - 1; column <= middle.column + 1; ++column) {
      const SurfaceCell* const cell = surfaces.find({column, row});
      if (cell == nullptr) continue;
      if (std::ranges::any_of(cell->sums, [](const SurfaceSum& s) { return s.weight > 0.0F; })) {
        return true;
      }
    }
  }
  return false;
}

bool is_free(const Submap& submap, const Eigen::Vector2d& point) {
  const auto& free = submap.state().free;
  const std::uint8_t* const passed = free.find(free.cell_of(point.x(), point.y()));
  return passed != nullptr && *passed != 0;
}

/// A scan where it is expected.
class ScanInSubmap {
 public:
  ScanInSubmap(const LaserScan& scan, const Pose2& submap_T_lidar, const Submap& submap,
               BeamTable& beams)
      : scan_(scan),
        submap_(submap),
        directions_(beams.directions(scan)),
        from_(submap_T_lidar.translation()),
        rotation_(submap_T_lidar.rotation()) {}

  [[nodiscard]] std::size_t size() const { return directions_.size(); }
  [[nodiscard]] bool is_return(std::size_t i) const {
    return scan_.ranges_m[i] > 0.0F && std::isfinite(scan_.ranges_m[i]);
  }
  [[nodiscard]] bool is_stranger(std::size_t i) const {
    if (!is_return(i) || scan_.ranges_m[i] > kLaserCheck.stranger_m) return false;
    const Eigen::Vector2d point = end_of(i);
    return is_free(submap_, point) && !has_surface(submap_, point);
  }
  [[nodiscard]] bool is_surface(std::size_t i) const { return has_surface(submap_, end_of(i)); }

 private:
  [[nodiscard]] Eigen::Vector2d end_of(std::size_t i) const {
    return from_ + static_cast<double>(scan_.ranges_m[i]) * (rotation_ * directions_[i]);
  }

  const LaserScan& scan_;
  const Submap& submap_;
  const std::vector<Eigen::Vector2d>& directions_;
  Eigen::Vector2d from_;
  Eigen::Matrix2d rotation_;
};

struct Strangers {
  std::vector<bool> beams{};
  std::size_t count = 0;
  std::size_t near_count = 0;
};

Strangers strangers_in(const ScanInSubmap& placed, const LaserScan& scan) {
  Strangers found{std::vector<bool>(placed.size(), false)};
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (!placed.is_stranger(i)) continue;
    found.beams[i] = true;
    ++found.count;
    if (is_near(scan.ranges_m[i])) ++found.near_count;
  }
  return found;
}

/// Whether the returns that are no strangers fall on surfaces.
bool rest_agrees(const ScanInSubmap& placed, const Strangers& strangers) {
  std::size_t rest = 0;
  std::size_t surfaces = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (strangers.beams[i] || !placed.is_return(i)) continue;
    ++rest;
    if (placed.is_surface(i)) ++surfaces;
  }
  return surfaces >= static_cast<std::size_t>(kLaserCheck.fewest_returns) &&
         static_cast<double>(surfaces) >= kLaserCheck.rest_agrees * static_cast<double>(rest);
}

/// Beams beside one another that show one thing, as the first and the one behind the last.
template <typename Use>
void for_each_thing(const LaserScan& scan, const Use& use) {
  const auto joins = [&](std::size_t i) {
    const float step_m = std::abs(scan.ranges_m[i] - scan.ranges_m[i - 1]);
    return step_m < kLaserCheck.stranger_step_m;  // false for what is no number
  };
  std::size_t first = 0;
  for (std::size_t i = 1; i <= scan.ranges_m.size(); ++i) {
    if (i < scan.ranges_m.size() && joins(i)) continue;
    use(first, i);
    first = i;
  }
}

void take_in_things(const LaserScan& scan, const Strangers& strangers, std::vector<bool>& out) {
  for_each_thing(scan, [&](std::size_t first, std::size_t end) {
    std::size_t strange = 0;
    for (std::size_t i = first; i < end; ++i) strange += strangers.beams[i] ? 1 : 0;
    const bool is_whole = 2 * strange >= end - first;
    for (std::size_t i = first; i < end; ++i) {
      if (is_whole || strangers.beams[i]) out[i] = true;
    }
  });
}

}  // namespace

LaserCover cover_of(const LaserScan& scan, const Pose2& submap_T_lidar, bool is_measured,
                    const Submap& submap, BeamTable& beams) {
  const ScanInSubmap placed(scan, submap_T_lidar, submap, beams);
  const Strangers strangers = strangers_in(placed, scan);
  const auto is_more = [&](std::size_t count, double share) {
    return static_cast<double>(count) > share * static_cast<double>(placed.size());
  };
  const bool is_covered = is_more(strangers.near_count, kLaserCheck.cover_share);
  const bool has_strangers = is_measured && is_more(strangers.count, kLaserCheck.stranger_share) &&
                             rest_agrees(placed, strangers);
  LaserCover cover;
  if (!is_covered && !has_strangers) return cover;
  cover.is_fault = is_covered || is_crowd(strangers.beams);
  cover.beams.assign(placed.size(), false);
  if (is_covered) {
    for (std::size_t i = 0; i < placed.size(); ++i) cover.beams[i] = is_near(scan.ranges_m[i]);
  }
  if (has_strangers) take_in_things(scan, strangers, cover.beams);
  return cover;
}

bool is_crowd(const std::vector<bool>& beams) {
  return static_cast<double>(std::ranges::count(beams, true)) >
         kLaserCheck.crowd_share * static_cast<double>(beams.size());
}

void take_out(const std::vector<bool>& beams, LaserScan& scan) {
  for (std::size_t i = 0; i < beams.size(); ++i) {
    if (beams[i]) scan.ranges_m[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace loopstone
