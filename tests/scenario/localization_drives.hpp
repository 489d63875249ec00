#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "../../bench/localization_runs.hpp"
#include "loopstone/localization/localizer.hpp"
#include "support/simulated_log.hpp"
#include "support/test_scale.hpp"

// Simulated drives, as bench/localization.py has them, and what a localizer said on the way beside
// the truth.
namespace loopstone::test {

using bench::error_of;
using bench::make_run;
using bench::PoseError;
using Drive = bench::Run;

/// Not where the drive is, but roughly.
[[nodiscard]] inline InitialPose guess_of(const Drive& drive) {
  return {drive.truth.front().pose * Pose2{0.2, -0.1, 0.1}, 0.3, 0.2};
}

[[nodiscard]] inline LocalizationResult localize(const LocalizationMap& map, const Drive& drive,
                                                 const std::optional<InitialPose>& initial = {},
                                                 std::uint64_t seed = 1, Threads threads = {1}) {
  Localizer localizer(map, drive.robot, {}, initial, seed, threads);
  for (const SensorMessage& message : drive.messages) localizer.add(message);
  return localizer.finish();
}

[[nodiscard]] inline LocalizationResult localize(const Drive& drive,
                                                 const std::optional<InitialPose>& initial = {},
                                                 std::uint64_t seed = 1, Threads threads = {1}) {
  return localize(LocalizationMap(drive.map), drive, initial, seed, threads);
}

/// What the estimates of a drive were worth.
struct Verdict {
  int scans = 0;
  int tracking = 0;
  int doubtful = 0;
  int lost = 0;
  int wrong_tracking = 0;
  int right = 0;
  double rmse_m = 0.0;  ///< over all estimates
  std::optional<double> first_tracking_m{};
  bool last_right = false;
};

[[nodiscard]] inline Verdict judge(const LocalizationResult& result, const Drive& drive) {
  Verdict verdict;
  double squares = 0.0;
  for (const LocalizationEstimate& estimate : result.estimates) {
    const PoseError error = error_of(estimate, drive);
    ++verdict.scans;
    squares += error.metres * error.metres;
    verdict.right += error.right() ? 1 : 0;
    verdict.last_right = error.right();
    verdict.doubtful += estimate.state == LocalizationState::kDoubtful ? 1 : 0;
    verdict.lost += estimate.state == LocalizationState::kLost ? 1 : 0;
    if (estimate.state != LocalizationState::kTracking) continue;
    ++verdict.tracking;
    verdict.wrong_tracking += error.right() ? 0 : 1;
    if (!verdict.first_tracking_m) verdict.first_tracking_m = estimate.travelled_m;
  }
  if (verdict.scans > 0) verdict.rmse_m = std::sqrt(squares / verdict.scans);
  return verdict;
}

/// The drive with every scan changed.
[[nodiscard]] inline Drive with_scans(Drive drive, const std::function<void(LaserScan&)>& change) {
  for (SensorMessage& message : drive.messages) {
    if (auto* scan = std::get_if<LaserScan>(&message)) change(*scan);
  }
  return drive;
}

/// A simulated log's drive on the true map of its world.
[[nodiscard]] inline Drive on_its_map(const SimulatedLog& log) {
  return {
      .map = true_map(log.world), .robot = log.robot, .messages = log.messages, .truth = log.truth};
}

/// Something hangs over a laser for a while: a ring of returns that travels with the robot.
[[nodiscard]] inline Drive covered(Drive drive, int lidar, double from_s, double to_s) {
  const Stamp first = drive.truth.front().stamp;
  Rng rng(5);
  return with_scans(std::move(drive), [&](LaserScan& scan) {
    const double time_s = (scan.stamp - first).seconds();
    if (scan.lidar != lidar || time_s < from_s || time_s > to_s) return;
    for (float& range : scan.ranges_m) range = static_cast<float>(rng.uniform(0.05, 0.29));
  });
}

/// The drive as a robot without wheels and gyro would have recorded it.
[[nodiscard]] inline Drive laser_alone(Drive drive) {
  std::erase_if(drive.messages, [](const SensorMessage& message) {
    return !std::holds_alternative<LaserScan>(message);
  });
  return drive;
}

}  // namespace loopstone::test
