#pragma once

#include <cmath>
#include <cstddef>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/mapping/rgbd_source.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

enum class ClockStatus {
  kEstimated,
  kNotObserved,  ///< the robot hardly changed its speed, or the floor has nothing to hold on to
};

constexpr auto words_of(ClockStatus /*any*/) {
  using enum ClockStatus;
  return std::array{Word{kEstimated, "estimated"}, Word{kNotObserved, "not_observed"}};
}

/// How a camera's clock stands to the trajectory's.
struct CameraClock {
  ClockStatus status = ClockStatus::kNotObserved;
  double late_s = 0.0;   ///< the camera's stamps less the true times
  double sigma_s = 0.0;  ///< standard deviation of that
  int pairs = 0;         ///< of frames that were compared
  /// More than two standard deviations: worth correcting.
  [[nodiscard]] bool is_significant() const {
    return status == ClockStatus::kEstimated && std::abs(late_s) > 2.0 * sigma_s;
  }
};

/// Compares how the floor moves between consecutive pictures with how the robot moved by the
/// trajectory, both shifted in time against each other: the shift that explains the turning best is
/// the offset of the clocks. Only moments count in which the turning changes. Offsets up to 0.3 s
/// are found.
///
/// \param camera  as it is really mounted (FloorPlaneEstimator)
/// Cost: about 2 ms for each pair of frames beside loading; at most `most_pairs` pairs.
/// Source: the motion from pictures is Baker and Matthews 2004, "Lucas-Kanade 20 years on", inverse
/// compositional.
[[nodiscard]] CameraClock estimate_camera_clock(const RgbdSource& source,
                                                const Trajectory& trajectory,
                                                const CameraModel& camera, Threads threads = {},
                                                std::size_t most_pairs = 150);

}  // namespace loopstone
