#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// How a robot goes along its route.
struct DriveOptions {
  double speed_m_s = 0.7;
  double yaw_rate_rad_s = 1.0;
  double acceleration_m_s2 = 0.6;
  double standstill_s = 3.0;
  int laps = 1;
};

/// A stretch of a drive over which the robot was lifted and carried [s since the start].
struct Carry {
  double from_s = 0.0;
  double to_s = 0.0;
  bool is_blind = false;  ///< no scans come meanwhile
};

/// A motion of constant speed and yaw rate in each of many short steps, so that the pose, the
/// distance and the angle turned are exact at every time, not only at samples.
class Drive {
 public:
  static constexpr double kStep = 0.02;  ///< [s]

  explicit Drive(const Pose2& map_T_start)
      : poses_{map_T_start}, travelled_m_{0.0}, turned_rad_{0.0} {}

  /// One more step.
  void append(double speed_m_s, double yaw_rate_rad_s);
  /// The steps of another drive, over which nobody carried it, from here on.
  void append(const Drive& other);
  /// Carried along a line from where it is, and turned to a heading, in steps of even speed; the
  /// wheels stand meanwhile.
  /// \param way  map frame, two points or more, from the last pose on
  void carry_along(std::span<const Eigen::Vector2d> way, double yaw, double duration_s,
                   bool is_blind);

  [[nodiscard]] double duration_s() const { return kStep * static_cast<double>(speeds_.size()); }
  [[nodiscard]] const Pose2& last_pose() const { return poses_.back(); }
  /// map_T_robot; times outside the drive give its first or last pose.
  [[nodiscard]] Pose2 pose_at(double time_s) const;
  /// Signed length of the path so far, less what it was carried [m].
  [[nodiscard]] double travelled_m(double time_s) const;
  /// Sum of all turning so far, not wrapped [rad].
  [[nodiscard]] double turned_rad(double time_s) const;
  /// What of it was turned by hands.
  [[nodiscard]] double turned_by_hand_rad(double time_s) const;
  [[nodiscard]] const std::vector<Carry>& carries() const { return carries_; }
  /// Along the robot's x axis; 0 outside, and while it is carried.
  [[nodiscard]] double speed_m_s(double time_s) const;
  /// Drops what comes after.
  void cut(double duration_s);
  /// The drive as it would be if it had begun so much later; one over which nobody carried it.
  [[nodiscard]] Drive without_first(double duration_s) const;

 private:
  struct At {
    std::size_t step = 0;
    double rest_s = 0.0;
  };
  [[nodiscard]] At at(double time_s) const;
  void append_hand(const Tangent2& per_s);
  [[nodiscard]] bool is_carried(std::size_t step) const;

  std::vector<Pose2> poses_;           ///< at the start of each step, and at the end
  std::vector<double> travelled_m_;    ///< likewise
  std::vector<double> turned_rad_;     ///< likewise
  std::vector<double> speeds_{};       ///< [m/s]
  std::vector<double> yaw_rates_{};    ///< [rad/s]
  std::vector<Tangent2> hands_{};      ///< a second, of each step; empty while nobody carried it
  std::vector<double> by_hand_rad_{};  ///< likewise, turned until the start of each step
  std::vector<Carry> carries_{};
};

/// Visits the world's places, each time the cheapest to reach of those that are left, ways driven
/// before being dearer; then passes its returns in order. Without returns it comes back to the
/// start. Places that a robot of that radius can't reach are left out. With more than one lap it
/// goes on to the start and along the same way again. The robot's centre never comes nearer to an
/// obstacle than the radius.
/// Throws UsageError when the start itself has no room for the robot.
/// Source of the steering: Coulter 1992, "Implementation of the pure pursuit path tracking
/// algorithm".
[[nodiscard]] Drive drive_route(const World& world, double robot_radius_m,
                                const DriveOptions& options = {});

}  // namespace loopstone
