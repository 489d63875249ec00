// Robots with several lasers, held against one laser alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "localization_drives.hpp"
#include "mapped_drives.hpp"
#include "two_corner_lasers.hpp"

namespace loopstone::test {
namespace {

SimulatedLog without_odometry(SimulatedLog log) {
  std::erase_if(log.messages, [](const SensorMessage& message) {
    return !std::holds_alternative<LaserScan>(message);
  });
  return log;
}

class SeveralLasers : public testing::TestWithParam<const char*> {
 protected:
  const SimulatedLog front_log_ = seen_from(kFrontCorner, 10.0, GetParam(), 31);
  const SimulatedLog rear_log_ = seen_from(kRearCorner, 11.0, GetParam(), 31);
};

TEST_P(SeveralLasers, TwoCornersMapAsWellAsTheBetterOneAlone) {
  const MapResult alone = map_of(front_log_);
  const MapResult other = map_of(rear_log_);
  const MapResult result = map_of(both(front_log_, rear_log_));
  EXPECT_EQ(result.statistics.scans, alone.statistics.scans + other.statistics.scans);
  const double best_m = std::min(
      ate_rmse_m(alone.trajectory, front_log_),
      absolute_error(other.trajectory, front_log_.truth, Alignment::kSe2).translation_m.rmse);
  const double error_m = ate_rmse_m(result.trajectory, front_log_);
  EXPECT_LT(error_m, 1.4 * best_m + 0.003);
  EXPECT_LE(result.statistics.searches, result.statistics.scans / 50) << "scans fit at once";
}

TEST_P(SeveralLasers, HoldOneAnotherWithoutOdometry) {
  const MapResult result = map_of(without_odometry(both(front_log_, rear_log_)));
  const MapResult alone = map_of(without_odometry(front_log_));
  const double alone_m = ate_rmse_m(alone.trajectory, front_log_);
  const double error_m = ate_rmse_m(result.trajectory, front_log_);
  EXPECT_LT(error_m, 1.5 * alone_m + 0.008);
}

// ---- on a map that is known

/// Root mean square of positions, of the estimates that are TRACKING.
double rmse_tracking_m(const LocalizationResult& result, const Drive& drive) {
  double squares = 0.0;
  int count = 0;
  for (const LocalizationEstimate& estimate : result.estimates) {
    if (estimate.state != LocalizationState::kTracking) continue;
    squares += std::pow(error_of(estimate, drive).metres, 2);
    ++count;
  }
  return count > 0 ? std::sqrt(squares / count) : 1e3;
}

TEST_P(SeveralLasers, FollowARobotOnAMapAsWellAsTheBetterOneAlone) {
  const Drive front = on_its_map(front_log_);
  const Drive rear = on_its_map(rear_log_);
  const Drive drive = on_its_map(both(front_log_, rear_log_));
  const LocalizationResult result = localize(drive);
  const Verdict verdict = judge(result, drive);
  EXPECT_EQ(result.estimates.size(), front_log_.scans().size() + rear_log_.scans().size());
  EXPECT_EQ(verdict.wrong_tracking, 0);
  // What one laser alone can't tell, the other one does: in the warehouse some aisles look alike.
  EXPECT_GE(verdict.tracking, 0.99 * verdict.scans);
  const double best_m =
      std::min(rmse_tracking_m(localize(front), front), rmse_tracking_m(localize(rear), rear));
  EXPECT_LT(rmse_tracking_m(result, drive), 1.2 * best_m + 0.001);
}

TEST_P(SeveralLasers, OfScansOfOneMomentOneHasAnEstimateAndBothCount) {
  const SimulatedLog rear_log = seen_from(kRearCorner, 10.0, GetParam(), 31);
  const Drive front = on_its_map(front_log_);
  const Drive drive = on_its_map(both(front_log_, rear_log));
  ASSERT_EQ(rear_log.scans().front().stamp, front_log_.scans().front().stamp);
  const LocalizationResult result = localize(drive);
  EXPECT_EQ(result.scans,
            static_cast<std::int64_t>(front_log_.scans().size() + rear_log.scans().size()));
  ASSERT_EQ(result.estimates.size(), front_log_.scans().size());
  for (std::size_t i = 1; i < result.estimates.size(); ++i)
    EXPECT_LT(result.estimates[i - 1].stamp, result.estimates[i].stamp);
  EXPECT_EQ(judge(result, drive).wrong_tracking, 0);
  EXPECT_LT(rmse_tracking_m(result, drive), rmse_tracking_m(localize(front), front));
}

TEST_P(SeveralLasers, OneThatIsCoveredLeavesTheRobotToTheOther) {
  const double to_s = small_scale() ? 30.0 : 40.0;
  const Drive drive = covered(on_its_map(both(front_log_, rear_log_)), 0, 10.0, to_s);
  const Verdict verdict = judge(localize(drive), drive);
  EXPECT_EQ(verdict.wrong_tracking, 0);
  EXPECT_GE(verdict.tracking, 0.99 * verdict.scans);
  // Alone it would not be known where the robot is.
  const Drive alone = covered(on_its_map(front_log_), 0, 10.0, to_s);
  const Verdict one = judge(localize(alone), alone);
  EXPECT_EQ(one.wrong_tracking, 0);
  EXPECT_LT(one.tracking, 0.9 * one.scans);
}

std::string world_name(const testing::TestParamInfo<const char*>& info) { return info.param; }

INSTANTIATE_TEST_SUITE_P(Worlds, SeveralLasers, testing::Values("office", "warehouse"), world_name);

}  // namespace
}  // namespace loopstone::test
