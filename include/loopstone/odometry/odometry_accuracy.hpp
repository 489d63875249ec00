#pragma once

#include <optional>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Where odometry and the laser put the robot when a window began.
struct OdometryWindow {
  Pose2 odom_T_robot{};
  Pose2 local_T_robot{};
  double path_m = 0.0;

  template <typename Archive>
  void archive(Archive& a) {
    a(odom_T_robot, local_T_robot, path_m);
  }
};

/// How far odometry is off after some metres, learned from where the laser could tell.
///
/// The drive is cut into windows of some metres; what odometry says of each is held against the
/// laser. Beyond a window errors add up as those of independent windows do, and a heading that is
/// off swings what lies far away:
///
///   g(L) = min(L, sqrt(window L)),   sigma_rad = r g,   sigma_m^2 = (s g)^2 + (sigma_rad D / 2)^2
///
/// with L the way, D how far it led, s and r the root mean squares of the errors a metre. As long
/// as there are few windows the first guess counts: wheels that nobody calibrated.
/// Cost: some nanoseconds a scan. Deterministic.
class OdometryAccuracy {
 public:
  /// Where both put the robot at the end of a motion that the laser saw.
  /// \param path_m  travelled by odometry since the recording began
  void add(const Pose2& odom_T_robot, const Pose2& local_T_robot, double path_m);
  /// The laser lost the robot: the window that is open says nothing.
  void interrupt() { open_.reset(); }

  /// One standard deviation after a way of that length [m], [rad]. \param reach_m from its
  /// beginning to its end
  [[nodiscard]] double sigma_m(double path_m, double reach_m) const;
  [[nodiscard]] double sigma_rad(double path_m) const;

  template <typename Archive>
  void archive(Archive& a) {
    a(open_, share2_, rad_per_m2_, windows_);
  }

 private:
  std::optional<OdometryWindow> open_{};
  double share2_ = 0.15 * 0.15;      ///< mean square of the error / the way
  double rad_per_m2_ = 0.03 * 0.03;  ///< mean square of the turn missed / the way
  double windows_ = 1.0;             ///< that the means are of; the first guess counts as one
};

}  // namespace loopstone
