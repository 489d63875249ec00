#pragma once

#include <deque>
#include <optional>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_correction.hpp"

namespace loopstone {

/// What the accuracy of odometry is learned by.
struct OdometryAccuracyNumbers {
  double window_m = 4.0;
  int most_windows = 40;
  int fewest_windows = 5;
  double least_share = 0.02;
  double least_rad_per_m = 0.004;
  double first_share = 0.15;
  double first_rad_per_m = 0.03;
};
inline constexpr OdometryAccuracyNumbers kOdometryAccuracy{};

template <typename Visitor>
void visit_numbers(const OdometryAccuracyNumbers& n, Visitor&& visit) {
  visit("window_m", n.window_m,
        "chosen: some metres, long beside the laser's noise, short enough that a drive has many");
  visit("most_windows", n.most_windows,
        "chosen: older windows are forgotten, after 160 m: floors and tyres change");
  visit("fewest_windows", n.fewest_windows,
        "chosen: so many, 20 m, before what is usual can be told");
  visit("least_share", n.least_share, "chosen: no wheels are better than two per cent for long");
  visit("least_rad_per_m", n.least_rad_per_m,
        "chosen: none keep their heading better than a quarter of a degree a metre for long");
  visit("first_share", n.first_share,
        "chosen: share of the way that may be wrong (one standard deviation): wheels that nobody "
        "calibrated, a floor that is not even; counts as one window");
  visit("first_rad_per_m", n.first_rad_per_m,
        "chosen: heading that such wheels lose by driving straight: as tyres that differ by 1.5 %, "
        "half a metre apart, do");
}

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

/// A window that is over.
struct OdometryWindowMotion {
  Pose2 told{};  ///< by odometry
  Pose2 seen{};  ///< by the laser
  double way_m = 0.0;

  template <typename Archive>
  void archive(Archive& a) {
    a(told, seen, way_m);
  }
};

/// How far odometry is off after some metres, learned from where the laser could tell.
///
/// The drive is cut into windows of some metres; what odometry says of each, without the errors
/// that are known, is held against the laser. Beyond a window errors add up as those of independent
/// windows do, and a heading that is off swings what lies far away:
///
///   g(L) = min(L, sqrt(window L)),   sigma_rad = r g,   sigma_m^2 = (s g)^2 + (sigma_rad D / 2)^2
///
/// with L the way, D how far it led, s and r the root mean squares of the errors a metre. As long
/// as there are few windows the first guess counts: wheels that nobody calibrated.
/// Cost: some nanoseconds a scan, some microseconds where it is asked. Deterministic.
class OdometryAccuracy {
 public:
  /// Where both put the robot at the end of a motion that the laser saw.
  /// \param path_m  travelled by odometry since the recording began
  void add(const Pose2& odom_T_robot, const Pose2& local_T_robot, double path_m);
  /// The laser lost the robot: the window that is open says nothing.
  void interrupt() { state_.open.reset(); }

  /// One standard deviation after a way of that length.
  struct Sigma {
    double m = 0.0;
    double rad = 0.0;
  };
  /// \param reach_m     from the beginning of the way to its end
  /// \param correction  what is known of odometry's errors, and taken away
  [[nodiscard]] Sigma sigma(double path_m, double reach_m,
                            const OdometryCorrection& correction) const;

  /// What the heading is usually off by after one window [rad]: the median. Nothing before there
  /// are enough of them.
  [[nodiscard]] std::optional<double> usual_rad(const OdometryCorrection& correction) const;

  /// What was learned.
  struct State {
    std::optional<OdometryWindow> open{};
    std::deque<OdometryWindowMotion> windows{};  ///< the last few

    template <typename Archive>
    void archive(Archive& a) {
      a(open, windows);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when it can't have been learned.
  void restore(State state);

 private:
  State state_{};
};

}  // namespace loopstone
