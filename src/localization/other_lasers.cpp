#include "localization/other_lasers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "localization/place_search.hpp"

namespace loopstone {

namespace {

/// What another laser saw so long ago still helps: two sweeps of a scanner that makes ten a second.
constexpr double kMomentS = 0.2;
/// What covers a laser is nearer than this.
constexpr double kCoverM = 0.5;
/// Of a laser that is covered fewer of the beams get beyond. Between walls on both sides of a small
/// robot, those along its way do.
constexpr double kLeastBeyond = 0.1;

}  // namespace

void OtherLasers::move(const Pose2& motion) {
  const Pose2 to_T_from = motion.inverse();
  for (Seen& seen : seen_) seen.now_T_then = to_T_from * seen.now_T_then;
}

void OtherLasers::remember(int lidar, Stamp stamp, const SeenByLaser& view) {
  auto seen = std::ranges::find(seen_, lidar, &Seen::lidar);
  if (seen == seen_.end()) seen = seen_.insert(seen_.end(), {.lidar = lidar});
  seen->stamp = stamp;
  seen->now_T_then = Pose2{};
  seen->view = view;
}

std::vector<SeenByLaser> OtherLasers::beside(int lidar, Stamp stamp) const {
  std::vector<SeenByLaser> views;
  for (const Seen& seen : seen_) {
    if (seen.lidar == lidar || std::abs((stamp - seen.stamp).seconds()) > kMomentS) continue;
    SeenByLaser view = seen.view;
    view.robot_T_lidar = seen.now_T_then * view.robot_T_lidar;
    for (Eigen::Vector2d& point : view.points_robot) point = seen.now_T_then * point;
    views.push_back(std::move(view));
  }
  return views;
}

bool sees(const SeenByLaser& view) {
  if (view.points_robot.size() < kLeastReturns) return false;
  const auto beyond = std::ranges::count_if(
      view.ranges_m, [](float range) { return static_cast<double>(range) > kCoverM; });
  return static_cast<double>(beyond) >= kLeastBeyond * static_cast<double>(view.ranges_m.size());
}

bool shows_place(const LocalizationScan& scan) { return std::ranges::any_of(scan.lasers, sees); }

}  // namespace loopstone
