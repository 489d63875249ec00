#pragma once

#include <gtest/gtest.h>

#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/simulated_log.hpp"
#include "support/test_scale.hpp"

// Simulated drives through the whole pipeline, held against their truth.
namespace loopstone::test {

[[nodiscard]] inline MapResult map_of(const SimulatedLog& log, const MapOptions& options = {},
                                      Threads threads = {}) {
  Mapper mapper(log.robot, options, threads);
  for (const auto& message : log.messages) mapper.add(message);
  return mapper.finish();
}

[[nodiscard]] inline double ate_rmse_m(const Trajectory& estimate, const SimulatedLog& log) {
  const AbsoluteError error = absolute_error(estimate, log.truth, Alignment::kSe2);
  EXPECT_EQ(error.poses_missing, 0);
  return error.translation_m.rmse;
}

}  // namespace loopstone::test
