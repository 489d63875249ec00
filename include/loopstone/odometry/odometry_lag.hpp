#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// Finds out whether odometry tells the right motions at the wrong time: over the last few hundred
/// scans, its motions are moved in time against those of the laser; when one shift explains them
/// four times better than none (an F-test with some hundred degrees of freedom on both sides),
/// odometry lags by it.
class OdometryLag {
 public:
  struct Step {
    Stamp from{};
    Stamp to{};
    double odometry_m = 0.0;  ///< forward
    double odometry_rad = 0.0;
    double laser_m = 0.0;
    double laser_rad = 0.0;
    bool sees_translation = true;
    bool sees_rotation = true;

    template <typename Archive>
    void archive(Archive& a) {
      a(from, to, odometry_m, odometry_rad, laser_m, laser_rad, sees_translation, sees_rotation);
    }
  };

  void add(const Step& step);

  /// How late odometry is; nothing while it is in time, as far as is known.
  [[nodiscard]] std::optional<double> lag_s() const { return lag_s_; }

  template <typename Archive>
  void archive(Archive& a) {
    a(steps_, since_judged_, lag_s_);
  }

 private:
  void judge();

  std::deque<Step> steps_{};
  std::size_t since_judged_ = 0;
  std::optional<double> lag_s_{};
};

}  // namespace loopstone
