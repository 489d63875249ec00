#pragma once

#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_reading.hpp"

namespace loopstone {

/// What the robot is known by to be in somebody's hands.
struct LiftWatchNumbers {
  double stands_m = 0.02;
  double stands_rad = 0.05;
  double rests_m = 0.05;
  double moves_m = 0.3;
  double turns_rad = 0.25;
  double at_least_s = 0.8;
  double unseen_s = 0.3;
  double longest_s = 8.0;
};
inline constexpr LiftWatchNumbers kLiftWatch{};

template <typename Visitor>
void visit_numbers(const LiftWatchNumbers& n, Visitor&& visit) {
  visit("stands_m", n.stands_m, "chosen: wheels that stand roll no farther, and no gyro moves it");
  visit("stands_rad", n.stands_rad,
        "chosen: as stands_m, of a point half a metre off; a laser that sees a robot stand turns "
        "it by less");
  visit("rests_m", n.rests_m, "chosen: as stands_rad: what a laser sees of a robot that stands");
  visit("moves_m", n.moves_m,
        "chosen: on wheels that stand a robot does not slip so far, nor is a laser so wrong");
  visit("turns_rad", n.turns_rad, "chosen: as moves_m, of a point a metre off");
  visit("at_least_s", n.at_least_s,
        "chosen: wheels whose readings are late seem to stand for less while the robot turns");
  visit("unseen_s", n.unseen_s,
        "chosen: in less time nobody carries a robot farther than a scan tells by itself");
  visit(
      "longest_s", n.longest_s,
      "chosen: who moves a robot out of the way sets it down sooner; wheels that stand for longer "
      "while it moves are stuck");
}

/// A time in which the robot was in somebody's hands.
struct Lift {
  Stamp from{};           ///< it stood until then
  double unseen_s = 0.0;  ///< in which the laser left a direction open, or told nothing

  template <typename Archive>
  void archive(Archive& a) {
    a(from, unseen_s);
  }
};

/// Notices that somebody carries the robot while the laser looks on: a robot does not move
/// whose wheels stand. Along a corridor, which leaves open how far it is carried, turns tell.
/// Cost: nothing. Deterministic.
class LiftWatch {
 public:
  /// The robot's pose at a scan, as it was settled.
  /// \param sees_translation, sees_rotation  the laser held them
  void add(Stamp stamp, const OdometryReading& reading, const Pose2& local_T_robot,
           bool sees_translation, bool sees_rotation);
  /// Nothing tells whether its wheels stand.
  void forget() { state_ = {}; }

  [[nodiscard]] bool is_lifted() const { return state_.is_lifted && !state_.is_stuck; }
  /// How far a gyro has felt the robot turn by hand since the wheels stand [rad].
  [[nodiscard]] double felt_rad(const OdometryReading& reading) const;
  /// The lift that is over by the time of this reading, since the wheels turn again, or have stood
  /// for so long that odometry must be stuck.
  [[nodiscard]] std::optional<Lift> ended_by(const OdometryReading& reading) const;

  struct State {
    std::optional<OdometryReading> stands{};  ///< since this reading
    Pose2 local_T_robot{};                    ///< then
    Stamp last{};                             ///< of the last scan
    Lift lift{};                              ///< of one that may have begun
    bool is_lifted = false;
    bool is_stuck = false;

    template <typename Archive>
    void archive(Archive& a) {
      a(stands, local_T_robot, last, lift, is_lifted, is_stuck);
    }
  };
  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when nothing can have led to it.
  void restore(const State& state);

 private:
  [[nodiscard]] bool still_stands(const OdometryReading& reading) const;

  State state_{};
};

}  // namespace loopstone
