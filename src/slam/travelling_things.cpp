#include "loopstone/slam/travelling_things.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kFullTurn = 2.0 * kPi;
/// Beams to either side that are asked, however fine the scan.
constexpr double kMostBeside = 32.0;

bool is_return(float range_m) { return range_m > 0.0F && std::isfinite(range_m); }

double margin_at(double range_m) {
  return kTravelling.margin_m + kTravelling.margin_share * range_m;
}

/// Whether its beams point anywhere.
bool has_bearings(const LaserScan& scan) {
  return std::isfinite(scan.angle_min_rad) && std::isnormal(scan.angle_increment_rad);
}

bool same_laser(const LaserScan& a, const LaserScan& b) {
  return a.lidar == b.lidar && a.ranges_m.size() == b.ranges_m.size() &&
         a.angle_min_rad == b.angle_min_rad && a.angle_increment_rad == b.angle_increment_rad;
}

/// What a scan says along some direction.
struct Reach {
  double nearest_m = std::numeric_limits<double>::infinity();
  double farthest_m = 0.0;  ///< infinite where a beam found nothing
  double farthest_return_m = 0.0;
};

/// A scan to be asked about points in its frame.
class Sight {
 public:
  explicit Sight(const LaserScan& scan)
      : scan_(scan),
        spread_(static_cast<int>(
            std::clamp(std::ceil(kTravelling.bearing_rad / std::abs(scan.angle_increment_rad)), 1.0,
                       kMostBeside))) {}

  [[nodiscard]] double range_m(std::size_t beam) const { return scan_.ranges_m[beam]; }
  [[nodiscard]] double range_max_m() const { return scan_.range_max_m; }
  /// Of the beams beside one another that may have met the point. Nothing where one of them is
  /// bad, or does not look there.
  [[nodiscard]] std::optional<Reach> towards(const Eigen::Vector2d& point) const {
    return towards(point, false);
  }
  /// The same of those that are not bad.
  [[nodiscard]] std::optional<Reach> by_the_good(const Eigen::Vector2d& point) const {
    return towards(point, true);
  }

 private:
  [[nodiscard]] std::optional<Reach> towards(const Eigen::Vector2d& point, bool skips_bad) const {
    double turn = std::atan2(point.y(), point.x()) - scan_.angle_min_rad;
    if (scan_.angle_increment_rad < 0.0) turn = -turn;
    turn -= kFullTurn * std::floor(turn / kFullTurn);
    const double beam = turn / std::abs(scan_.angle_increment_rad);
    const auto last = static_cast<double>(scan_.ranges_m.size()) - 1.0;
    if (beam < spread_ || beam > last - spread_) return {};
    const auto middle = static_cast<int>(std::lround(beam));
    const int first = std::max(0, middle - spread_);
    Reach reach;
    for (int i = first; i <= middle + spread_; ++i) {
      if (static_cast<std::size_t>(i) >= scan_.ranges_m.size()) break;
      const double range_m = scan_.ranges_m[static_cast<std::size_t>(i)];
      if (!(range_m > 0.0)) {  // nor what is no number
        if (skips_bad) continue;
        return {};
      }
      reach.nearest_m = std::min(reach.nearest_m, range_m);
      reach.farthest_m = std::max(reach.farthest_m, range_m);
      if (std::isfinite(range_m))
        reach.farthest_return_m = std::max(reach.farthest_return_m, range_m);
    }
    if (reach.farthest_m == 0.0) return {};
    return reach;
  }

  const LaserScan& scan_;
  int spread_;
};

/// Two scans, and the way of the robot between them.
class Comparison {
 public:
  Comparison(const LaserScan& now, const TravellingThings::View& then, const Pose2& ground_T_lidar,
             double way_m)
      : now_(now), then_(then.scan), way_m_(way_m) {
    const Pose2 then_T_now = then.ground_T_lidar.inverse() * ground_T_lidar;
    rotation_ = then_T_now.rotation();
    translation_ = then_T_now.translation();
  }

  /// Whether something that moves returned the beam that ends at a point.
  [[nodiscard]] bool moves(std::size_t beam, const Eigen::Vector2d& end) const {
    const Eigen::Vector2d before = rotation_ * end + translation_;
    const double range_m = before.norm();
    const auto seen = then_.towards(before);
    if (!seen || !std::isfinite(seen->farthest_m)) return false;
    const double margin_m = margin_at(range_m);
    if (seen->nearest_m > range_m + margin_m) return true;
    const double short_by_m = range_m - seen->farthest_m;
    if (short_by_m < margin_m || short_by_m > kTravelling.fastest * way_m_) return false;
    return goes_along(beam) || is_gone(before * (seen->farthest_m / range_m));
  }

  /// Whether the scan before showed something there. Nothing where no beam looked there.
  [[nodiscard]] std::optional<bool> confirms(const Eigen::Vector2d& end) const {
    const Eigen::Vector2d before = rotation_ * end + translation_;
    const double range_m = before.norm();
    const double margin_m = kTravelling.margin_m + kTravelling.confirmed_share * range_m;
    if (range_m > then_.range_max_m() - margin_m) return {};
    const auto seen = then_.by_the_good(before);
    if (!seen) return {};
    return seen->nearest_m <= range_m + margin_m && seen->farthest_return_m >= range_m - margin_m;
  }

 private:
  /// Whether the beam is as long as it was.
  [[nodiscard]] bool goes_along(std::size_t beam) const {
    const double change_m = now_.range_m(beam) - then_.range_m(beam);
    return std::abs(change_m) < kTravelling.same_m;  // false for what is no number
  }
  /// Whether beams now pass through what was seen before.
  [[nodiscard]] bool is_gone(const Eigen::Vector2d& before) const {
    const Eigen::Vector2d here = rotation_.transpose() * (before - translation_);
    const auto seen = now_.towards(here);
    const double range_m = here.norm();
    return seen && seen->nearest_m > range_m + margin_at(range_m);
  }

  Sight now_;
  Sight then_;
  double way_m_;
  Eigen::Matrix2d rotation_ = Eigen::Matrix2d::Identity();
  Eigen::Vector2d translation_ = Eigen::Vector2d::Zero();
};

/// Leaves those beside which enough others say the same. \return how many are left
std::size_t keep_things(std::vector<bool>& found) {
  std::size_t kept = 0;
  for (std::size_t first = 0; first < found.size(); ++first) {
    if (!found[first]) continue;
    std::size_t end = first + 1;
    while (end < found.size() && found[end]) ++end;
    const std::size_t count = end - first;
    if (count >= static_cast<std::size_t>(kTravelling.fewest_beams)) {
      kept += count;
    } else {
      for (std::size_t i = first; i < end; ++i) found[i] = false;
    }
    first = end;
  }
  return kept;
}

std::vector<Comparison> comparisons_of(const std::deque<TravellingThings::View>& views,
                                       const LaserScan& scan, const Pose2& ground_T_lidar,
                                       double path_m) {
  std::vector<Comparison> comparisons;
  for (const double way_m : {kTravelling.short_m, kTravelling.long_m}) {
    const auto then =
        std::ranges::find_if(views.rbegin(), views.rend(), [&](const TravellingThings::View& v) {
          return path_m - v.path_m >= way_m && same_laser(v.scan, scan);
        });
    if (then == views.rend()) continue;
    comparisons.emplace_back(scan, *then, ground_T_lidar, path_m - then->path_m);
  }
  return comparisons;
}

Eigen::Matrix2d spread_of_normals(std::span<const SurfacePoint> surfaces) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const SurfacePoint& surface : surfaces) {
    const Eigen::Vector2d normal = surface.normal.cast<double>();
    sum += static_cast<double>(surface.weight) * normal * normal.transpose();
  }
  return sum;
}

}  // namespace

std::vector<bool> TravellingThings::find(const LaserScan& scan, const Pose2& ground_T_lidar,
                                         double path_m, const std::vector<bool>& covered,
                                         BeamTable& beams) const {
  const auto comparisons = comparisons_of(state_.views, scan, ground_T_lidar, path_m);
  if (comparisons.empty()) return {};
  const std::vector<Eigen::Vector2d>& directions = beams.directions(scan);
  const auto is_asked = [&](std::size_t i) {
    return is_return(scan.ranges_m[i]) && (covered.empty() || !covered[i]);
  };
  std::vector<bool> found(directions.size(), false);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (!is_asked(i)) continue;
    const Eigen::Vector2d end = static_cast<double>(scan.ranges_m[i]) * directions[i];
    found[i] =
        std::ranges::any_of(comparisons, [&](const Comparison& c) { return c.moves(i, end); });
  }
  if (keep_things(found) == 0) return {};
  std::size_t far = 0;
  std::size_t far_found = 0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (!is_asked(i) || scan.ranges_m[i] < kTravelling.near_m) continue;
    ++far;
    if (found[i]) ++far_found;
  }
  if (static_cast<double>(far_found) > kTravelling.most_share * static_cast<double>(far)) return {};
  return found;
}

std::vector<bool> TravellingThings::find_new(const LaserScan& scan, const Pose2& ground_T_lidar,
                                             double path_m, const std::vector<bool>& covered,
                                             BeamTable& beams) const {
  const auto comparisons = comparisons_of(state_.views, scan, ground_T_lidar, path_m);
  if (comparisons.empty()) return {};
  const std::vector<Eigen::Vector2d>& directions = beams.directions(scan);
  std::vector<bool> found(directions.size(), false);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (!is_return(scan.ranges_m[i]) || (!covered.empty() && covered[i])) continue;
    const Eigen::Vector2d end = static_cast<double>(scan.ranges_m[i]) * directions[i];
    bool is_denied = false;
    bool is_confirmed = false;
    for (const Comparison& comparison : comparisons) {
      const std::optional<bool> confirmed = comparison.confirms(end);
      if (!confirmed) continue;
      (*confirmed ? is_confirmed : is_denied) = true;
    }
    found[i] = is_denied && !is_confirmed;
  }
  if (keep_things(found) == 0) return {};
  return found;
}

void TravellingThings::remember(const LaserScan& scan, const Pose2& ground_T_lidar, double path_m) {
  if (!has_bearings(scan)) return;
  auto& views = state_.views;
  const auto last = std::ranges::find_if(views.rbegin(), views.rend(),
                                         [&](const View& v) { return v.scan.lidar == scan.lidar; });
  if (last != views.rend() && path_m - last->path_m < kTravelling.every_m) return;
  views.push_back({scan, ground_T_lidar, path_m});
  // Of this laser's, the last one that is far enough back stays.
  const auto is_older = [&](const View& v) {
    return v.scan.lidar == scan.lidar && path_m - v.path_m >= kTravelling.long_m;
  };
  const auto stays = std::ranges::find_if(views.rbegin(), views.rend(), is_older);
  if (stays == views.rend()) return;
  const double path_that_stays_m = stays->path_m;
  std::erase_if(views, [&](const View& v) {
    return v.scan.lidar == scan.lidar && v.path_m < path_that_stays_m;
  });
}

void TravellingThings::restore(State state) {
  for (const View& view : state.views) {
    require_sound(view.ground_T_lidar.vector().allFinite() && std::isfinite(view.path_m),
                  "a scan of a while ago that was taken nowhere");
    require_sound(has_bearings(view.scan), "beams that point nowhere");
  }
  state_ = std::move(state);
}

bool leave_open(std::span<const SurfacePoint> surfaces) {
  const auto axes = symmetric_eigen<double, 2>(spread_of_normals(surfaces));
  return axes.values(0) < kTravelling.weak_share * axes.values(1);
}

Eigen::Vector2d weakest_axis(std::span<const SurfacePoint> surfaces) {
  return symmetric_eigen<double, 2>(spread_of_normals(surfaces)).vectors.col(0);
}

}  // namespace loopstone
