#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/tracked_pose.hpp"

namespace loopstone {

/// What calibration decides by.
struct CalibrationNumbers {
  double span_s = 0.7;
  double longest_span_s = 3.0;
  double still_m = 0.02;
  double still_rad = 0.02;
  double clear_m = 0.1;
  double clear_rad = 0.1;
  double enough_m = 3.0;
  double enough_rad = 3.0;
  double noise_floor = 1e-5;
  double outlier_sigmas = 3.0;
  int lags = 8;
  int blocks = 6;
  int fewest_motions = 40;
  int passes = 25;
  double delay_share = 0.3;
  double scale_least = 0.5;
  double scale_most = 2.0;
  double yaw_known_rad = 0.0087;
  double place_known_m = 0.02;
  double scale_known = 0.02;
  double open_travel_harmless_m = 0.1;
  double scale_sigma = 0.01;
  double scale_least_off = 0.005;
  double bias_known_rad_s = 0.01;
  double delay_known_s = 0.02;
  double sigmas = 3.0;
  double yaw_off_rad = 0.001745;
  double place_off_m = 0.005;
  double half_agrees = 0.5;
  double opposite = 0.8;
  double opposite_in_part = 0.5;
};
inline constexpr CalibrationNumbers kCalibration{};

template <typename Visitor>
void visit_numbers(const CalibrationNumbers& n, Visitor&& visit) {
  visit("span_s", n.span_s,
        "chosen: motions so long are compared; some decimetres, beside which the laser's noise is "
        "small and odometry's drift is, too");
  visit("longest_span_s", n.longest_span_s, "chosen: a longer one bridges a gap");
  visit("still_m", n.still_m, "chosen: a motion that is shorter, and turns less, tells nothing");
  visit("still_rad", n.still_rad, "chosen: the same of the turn");
  visit("clear_m", n.clear_m, "chosen: motions that are longer are no noise");
  visit("clear_rad", n.clear_rad, "chosen: turns that are larger are no noise");
  visit("enough_m", n.enough_m,
        "chosen: of such motions, so that they tell the yaw; else it is held as given");
  visit("enough_rad", n.enough_rad, "chosen: of such turns, so that they tell the place");
  visit("noise_floor", n.noise_floor, "chosen: nothing is known better [m, rad]");
  visit("outlier_sigmas", n.outlier_sigmas,
        "chosen: Geman and McClure's weight falls to a quarter there; slips are far beyond");
  visit("lags", n.lags,
        "chosen: motions that follow one another closer than this may share their errors (Newey "
        "and West 1987), six seconds");
  visit("blocks", n.blocks,
        "chosen: stretches of the log whose results show by their scatter what the residuals hide");
  visit("fewest_motions", n.fewest_motions, "chosen: fewer are no basis for a judgement");
  visit("passes", n.passes, "chosen: of reweighting; it settles within ten");
  visit("delay_share", n.delay_share,
        "chosen: of the way driven within the laser's delay, this much is not told apart from its "
        "place: the points of a sweep are of different times");
  visit("scale_least", n.scale_least,
        "chosen: odometry that tells less, or turns the other way, is no odometry to calibrate by");
  visit("scale_most", n.scale_most, "chosen: nor one that tells more");
  visit("yaw_known_rad", n.yaw_known_rad, "chosen: known to half a degree, it is observable");
  visit("place_known_m", n.place_known_m, "chosen: likewise");
  visit("scale_known", n.scale_known, "chosen: likewise");
  visit("scale_sigma", n.scale_sigma,
        "chosen: wheels slip more in one place than in another, so what the drive told of them "
        "elsewhere holds in a bare corridor to one per cent");
  visit("scale_least_off", n.scale_least_off,
        "chosen: half a per cent: a log is not mapped anew for less, ten centimetres in 20 m");
  visit("open_travel_harmless_m", n.open_travel_harmless_m,
        "chosen: two cells: corridors that are off by less in sum are not mapped anew");
  visit("bias_known_rad_s", n.bias_known_rad_s, "chosen: likewise");
  visit("delay_known_s", n.delay_known_s, "chosen: likewise");
  visit("sigmas", n.sigmas, "chosen: less may be chance");
  visit("yaw_off_rad", n.yaw_off_rad, "chosen: less than a tenth of a degree harms nobody");
  visit("place_off_m", n.place_off_m, "chosen: less than half a centimetre harms nobody");
  visit("half_agrees", n.half_agrees,
        "chosen: each half of the log must ask for this share of the correction at least");
  visit("opposite", n.opposite,
        "chosen: correlation of turns, but for the sign, from which on they go opposite ways");
  visit("opposite_in_part", n.opposite_in_part,
        "chosen: and of each stretch of the log that turned enough, where noise is more of it");
}

/// A value that a log tells.
struct CalibratedValue {
  double value = 0.0;
  double sigma = 0.0;       ///< one standard deviation
  double given = 0.0;       ///< as the robot file or the log has it
  bool observable = false;  ///< the robot moved so that the log tells it
};

/// How the sensors of a robot sit and count, as its own motion tells. What is not observable keeps
/// a value that means nothing.
struct Calibration {
  std::int64_t motions = 0;  ///< that were compared; 0: none of it is known
  Pose2 robot_T_lidar_given{};
  CalibratedValue lidar_x_m{};  ///< of robot_T_lidar, like the next two
  CalibratedValue lidar_y_m{};
  CalibratedValue lidar_yaw_rad{};
  Eigen::Matrix3d lidar_covariance = Eigen::Matrix3d::Zero();  ///< (x, y, yaw)
  CalibratedValue translation_scale{};                         ///< odometry's way / the laser's
  CalibratedValue rotation_scale{};                            ///< odometry's turns / the laser's
  CalibratedValue turn_bias_rad_s{};  ///< odometry turns so fast while the robot does not
  CalibratedValue turn_per_m_rad{};   ///< odometry turns so far a metre while the robot does not
  /// Scans show the robot so long after their stamp, by odometry's clock.
  CalibratedValue laser_delay_s{};
  /// The laser turns the other way than odometry, all along; who is right is another matter.
  bool turns_opposite = false;
  /// It is the laser: its beams go round the other way. Odometry and gyro agree with one another,
  /// or the log has dead reckoning and no gyro.
  bool laser_is_mirrored = false;
  bool mirror_is_in_doubt = false;  ///< no gyro says so; else the map is a mirror image
  CalibratedValue sweep_s{};        ///< from the first beam to the last, where scans do not tell
  bool sweep_is_off = false;        ///< significant, and both halves of the log say so
  bool beams_corrected = false;     ///< the map was made anew with mirrored beams, or that sweep
  /// Odometry's way / the laser's, of the motions that the laser held in every direction; 0: of too
  /// few.
  double odometry_scale = 0.0;
  bool scale_is_off = false;         ///< bare corridors were driven before it was known
  double open_travel_error_m = 0.0;  ///< they are too long by so much in sum
  bool scale_corrected = false;      ///< the map was made anew with it
  bool yaw_is_off = false;      ///< the mount's yaw: significant, and both halves of the log say so
  bool place_is_off = false;    ///< its x and y: likewise
  bool is_corrected = false;    ///< the map has the corrected mount
  int lidar = 0;                ///< LaserScan::lidar of the mount
  bool several_mounts = false;  ///< lasers, or places of one; what is told is of the first

  [[nodiscard]] bool mount_is_off() const { return yaw_is_off || place_is_off; }
  [[nodiscard]] bool beams_are_off() const { return laser_is_mirrored || sweep_is_off; }
  /// By what it can't be put right for afterwards: it must be made anew, see robot_correction.hpp.
  [[nodiscard]] bool map_is_bent() const { return beams_are_off() || scale_is_off; }
  /// The mount with what is off put right, and all else as given.
  [[nodiscard]] Pose2 robot_T_lidar() const;
};

/// A time that calibration leaves out.
struct TimeSpan {
  Stamp from{};
  Stamp to{};
};

/// Whether the laser turned as odometry tells, all in all, where the laser saw how it turned, and
/// turned enough. An upside-down laser that nothing placed may seem to.
[[nodiscard]] bool turns_agree(const std::deque<TrackedPose>& track);

/// Compares the motions of odometry with those of the laser, over spans of 0.7 s.
///
/// With the mount that is wrong by D (true robot_T_lidar = D * given), a motion (t, theta) of the
/// robot as the laser tells it, and odometry that is too long by s and late by tau:
///   odometry = s (R(D) t + (I - R(theta)) d) - tau * (its change when both ends are read later)
/// which is linear in s cos, s sin, s d and tau (after Censi et al. 2013, 'Simultaneous calibration
/// of odometry and sensor parameters for mobile robots', whose cost it shares; theirs is of wheel
/// speeds and laser alone). Headings that odometry loses meanwhile turn its motion by half of their
/// error. Outliers (slips) weigh little. Covariances hold for residuals that follow from one
/// another (Newey and West 1987), and grow where stretches of the log disagree by more than they
/// say (Birge 1932).
/// \param track          of all scans; those without odometry count for nothing
/// \param robot_T_lidar  as it was assumed when the track was made
/// \param left_out       when the laser did not hold the pose, or odometry stood still
/// Cost: about a millisecond for a thousand motions.
[[nodiscard]] Calibration calibrate(const std::deque<TrackedPose>& track,
                                    const Pose2& robot_T_lidar,
                                    std::span<const TimeSpan> left_out = {});

}  // namespace loopstone
