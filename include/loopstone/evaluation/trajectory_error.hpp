#pragma once

#include <cstdint>

#include "loopstone/base/stamp.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

struct ErrorStatistics {
  double mean = 0.0;
  double std = 0.0;  ///< with n - 1
  double rmse = 0.0;
  double median = 0.0;
  double max = 0.0;
};

enum class Alignment { kNone, kSe2 };

/// Absolute trajectory error.
struct AbsoluteError {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_rad;   ///< of |wrapped heading difference|
  Pose2 reference_T_estimate;     ///< the alignment that was applied
  std::int64_t poses = 0;         ///< that were compared
  std::int64_t poses_missing = 0; ///< reference poses outside the estimate's time
};

}  // namespace loopstone
