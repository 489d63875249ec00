#pragma once

#include <cstdint>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// What is known of the motion between two moments: the pose of the robot at `to`, seen from its
/// pose at `from`.
struct Relation {
  Stamp from;
  Stamp to;
  Pose2 from_T_to;
};

/// The error's translation depends on the order of the product; its rotation does not.
enum class RelationErrorOrder {
  /// d * e^-1, as Cartographer's tool has it; the published figures
  kMeasuredTimesInverseExpected,
  kInverseExpectedTimesMeasured,  ///< e^-1 * d, the difference as seen from the true pose at `to`
};

constexpr auto words_of(RelationErrorOrder /*any*/) {
  using enum RelationErrorOrder;
  return std::array{Word{kMeasuredTimesInverseExpected, "measured-first"},
                    Word{kInverseExpectedTimesMeasured, "expected-first"}};
}

/// The relations metric.
struct RelationsError {
  ErrorStatistics translation_m;
  ErrorStatistics squared_translation_m2;
  ErrorStatistics rotation_rad;
  ErrorStatistics squared_rotation_deg2;
  std::int64_t pairs = 0;               ///< relations that were compared
  std::int64_t pairs_interpolated = 0;  ///< of them, those with a stamp between two poses
  std::vector<Relation> missing{};      ///< relations outside the trajectory's time
};

/// How well a trajectory keeps the motions that are known to be true. A pose with the relation's
/// very stamp (to 0.1 ms) is taken where there is one, an interpolated one otherwise; stamps
/// outside the trajectory are missing, never clamped.
/// Source: Kuemmerle et al. 2009, "On measuring the accuracy of SLAM algorithms", equations 3 to 5.
/// Cost: O(relations * log(poses)).
[[nodiscard]] RelationsError relations_error(
    const Trajectory& estimate, const std::vector<Relation>& relations,
    RelationErrorOrder order = RelationErrorOrder::kMeasuredTimesInverseExpected);

}  // namespace loopstone
