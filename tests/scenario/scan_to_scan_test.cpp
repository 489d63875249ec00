#include "loopstone/slam/scan_to_scan.hpp"

#include <gtest/gtest.h>

#include "loopstone/evaluation/trajectory_error.hpp"
#include "support/simulated_log.hpp"
#include "support/usual_figure.hpp"

namespace loopstone {
namespace {

TEST(ScanToScanScenario, BeatsDeadReckoningInAnOffice) {
  SimulationOptions simulation;
  simulation.laser.rate_hz = 5.0;
  simulation.laser.beams = 361;
  const test::SimulatedLog log = test::simulate_log("office", 1, simulation);
  ScanToScanMapper mapper(log.robot);
  for (const SensorMessage& message : log.messages) mapper.add(message);
  const MapResult result = mapper.finish();

  const auto odometry = absolute_error(result.odometry, log.truth, Alignment::kSe2);
  const auto mapped = absolute_error(result.trajectory, log.truth, Alignment::kSe2);
  ASSERT_GT(mapped.poses, 1000);
  EXPECT_TRUE(test::as_usual(mapped.translation_m.rmse / odometry.translation_m.rmse, 0.54));
  EXPECT_TRUE(test::as_usual(mapped.rotation_rad.rmse / odometry.rotation_rad.rmse, 0.56));
  // Step by step it is far better than wheels: this is what ICP measures.
  const auto odometry_steps = relative_error(result.odometry, log.truth, 1.0, Spacing::kMetres);
  const auto mapped_steps = relative_error(result.trajectory, log.truth, 1.0, Spacing::kMetres);
  EXPECT_TRUE(
      test::as_usual(mapped_steps.translation_m.rmse / odometry_steps.translation_m.rmse, 0.40));
}

}  // namespace
}  // namespace loopstone
