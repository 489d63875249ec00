#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// What the search for a lag of odometry decides by.
struct OdometryLagNumbers {
  int steps = 256;
  int fewest_steps = 48;
  int judge_every = 16;
  double finest_s = 0.05;
  double longest_s = 1.0;
  int most_shifts = 10;
  double convincing = 4.0;
  double all_clear = 1.5;
  double noise2 = 2.5e-5;
  double clear_gain = 0.01;
  int fewest_better = 12;
  int better_than_worse = 4;
  double gap_s = 2.0;
};
inline constexpr OdometryLagNumbers kOdometryLag{};

template <typename Visitor>
void visit_numbers(const OdometryLagNumbers& n, Visitor&& visit) {
  visit("steps", n.steps,
        "chosen: half a minute at ten scans a second, so long that a robot speeds up and turns now "
        "and then");
  visit("fewest_steps", n.fewest_steps, "chosen: fewer say more of chance than of a shift");
  visit("judge_every", n.judge_every, "chosen: scans; every second or two is soon enough");
  visit("finest_s", n.finest_s,
        "chosen: shifts that are tried are as long as a scan takes, but not finer: less does no "
        "harm");
  visit("longest_s", n.longest_s,
        "chosen: longest shift that is tried; clocks that are farther apart are not of one robot");
  visit("most_shifts", n.most_shifts,
        "chosen: either way, so that the cost is bounded where scans are fast");
  visit("convincing", n.convincing,
        "derived: ratio of two sums of squares with a hundred degrees of freedom each (F-test): "
        "chance alone never reaches it");
  visit("all_clear", n.all_clear,
        "chosen: trust returns when the shift explains no more than that, about what chance does");
  visit("noise2", n.noise2,
        "derived: squared noise of one motion of the laser [m^2 + rad^2]: 4 mm and 3 mrad");
  visit("clear_gain", n.clear_gain,
        "chosen: a motion fits better when its error is smaller by so much [m or rad], more than "
        "the laser's noise");
  visit("fewest_better", n.fewest_better,
        "chosen: so many motions must fit better: no handful of outliers speaks for a shift");
  visit("better_than_worse", n.better_than_worse, "chosen: and so many times more than fit worse");
  visit("gap_s", n.gap_s,
        "chosen: motions that take longer are not of one stretch of the recording");
}

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
  [[nodiscard]] std::optional<double> lag_s() const { return state_.lag_s; }

  struct State {
    std::deque<Step> steps{};  ///< the last few hundred, each from where the one before ended
    std::size_t since_judged = 0;
    std::optional<double> lag_s{};

    template <typename Archive>
    void archive(Archive& a) {
      a(steps, since_judged, lag_s);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when its steps can't have followed one another.
  void restore(State state);

 private:
  void judge();

  State state_{};
};

}  // namespace loopstone
