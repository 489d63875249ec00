#pragma once

#include <string>
#include <string_view>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// The TUM trajectory format: one line a pose, `t x y z qx qy qz qw`, single spaces, none at the
/// end (evo refuses it). Seconds with nine digits, so that stamps survive to the nanosecond; metres
/// and quaternions with nine; qw >= 0.
[[nodiscard]] std::string format_tum(const Trajectory& trajectory);

/// Reads format_tum's output and what other tools write: comments (#), tabs, carriage returns,
/// exponents, poses in any order, a quaternion that is only nearly unit. Poses are projected to the
/// plane (z, roll and pitch are dropped). Throws DataError with the line for anything else, and
/// when there is no pose at all.
[[nodiscard]] Trajectory parse_tum(std::string_view text,
                                   const std::string& path_for_errors = "trajectory");

void write_tum(const std::string& path, const Trajectory& trajectory);
[[nodiscard]] Trajectory read_tum(const std::string& path, const MemoryBudget& budget = {});

}  // namespace loopstone
