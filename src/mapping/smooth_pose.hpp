#pragma once

#include <optional>

#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// The pose at a stamp by a cubic through the two poses on each side, each coordinate by itself
/// with tangents from its neighbours (Catmull and Rom 1974, for uneven steps). Between poses a
/// tenth of a second apart a robot that begins to turn is off by millimetres on the arc that
/// Trajectory::at takes, and by a tenth of that here. Where a neighbour is missing or far in time
/// the arc is taken. Nothing outside the trajectory's time.
[[nodiscard]] std::optional<Pose2> smooth_pose_at(const Trajectory& trajectory, Stamp stamp);

}  // namespace loopstone
