#include "loopstone/odometry/odometry_lag.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace loopstone {

namespace {

constexpr std::size_t kSteps = 256;
constexpr std::size_t kFewestSteps = 48;
constexpr std::size_t kJudgeEvery = 16;
/// Shifts that are tried: as long as a scan takes, but not finer than kFinest, up to kLongest or
/// kMostShifts.
constexpr double kFinestS = 0.05;
constexpr double kLongestS = 1.0;
constexpr int kMostShifts = 10;
/// A shift has to explain so much more than none; trust returns when it explains no more than that.
constexpr double kConvincing = 4.0;
constexpr double kAllClear = 1.5;
/// Squared noise of one motion of the laser [m^2 + rad^2]: 4 mm and 3 mrad.
constexpr double kNoise2 = 2.5e-5;
/// A motion fits better when its error is smaller by so much [m or rad]; so many have to, against
/// that many times fewer that fit worse.
constexpr double kClearGain = 0.01;
constexpr int kFewestBetter = 12;
constexpr int kBetterThanWorse = 4;
/// Steps farther apart are not of one stretch of the recording.
constexpr double kGapS = 2.0;

/// Odometry's way and heading over time, to be read between the stamps. Reads go forward in time.
class Unrolled {
 public:
  explicit Unrolled(const std::deque<OdometryLag::Step>& steps) {
    times_.push_back(0.0);
    way_.push_back(0.0);
    heading_.push_back(0.0);
    for (const auto& step : steps) {
      times_.push_back((step.to - steps.front().from).seconds());
      way_.push_back(way_.back() + step.odometry_m);
      heading_.push_back(heading_.back() + step.odometry_rad);
    }
  }
  struct State {
    double way_m;
    double heading_rad;
  };
  [[nodiscard]] double end_s() const { return times_.back(); }
  [[nodiscard]] State at(double time_s, std::size_t& hint) const {
    while (hint + 2 < times_.size() && times_[hint + 1] <= time_s) ++hint;
    const double span = times_[hint + 1] - times_[hint];
    const double ratio = span > 0.0 ? (time_s - times_[hint]) / span : 0.0;
    return {way_[hint] + ratio * (way_[hint + 1] - way_[hint]),
            heading_[hint] + ratio * (heading_[hint + 1] - heading_[hint])};
  }

 private:
  std::vector<double> times_{};
  std::vector<double> way_{};
  std::vector<double> heading_{};
};

/// How odometry differs from the laser when it is read later by a shift, motion by motion.
struct Misfit {
  std::vector<double> errors{};
  double squared = 0.0;
  std::size_t steps = 0;
};

Misfit misfit(const std::deque<OdometryLag::Step>& steps, const Unrolled& odometry, double shift_s,
              double margin_s) {
  Misfit result;
  std::size_t hint_from = 0;
  std::size_t hint_to = 0;
  const auto take = [&](bool seen, double error) {
    if (!seen) return;
    result.errors.push_back(error);
    result.squared += error * error;
  };
  for (const auto& step : steps) {
    const double from = (step.from - steps.front().from).seconds();
    const double to = (step.to - steps.front().from).seconds();
    if (from < margin_s || to > odometry.end_s() - margin_s) continue;
    const auto before = odometry.at(from + shift_s, hint_from);
    const auto after = odometry.at(to + shift_s, hint_to);
    take(step.sees_translation, after.way_m - before.way_m - step.laser_m);
    take(step.sees_rotation, after.heading_rad - before.heading_rad - step.laser_rad);
    ++result.steps;
  }
  return result;
}

/// Whether many motions fit better, and few worse: no handful of outliers speaks for a shift.
bool many_fit_better(const Misfit& shifted, const Misfit& none) {
  int better = 0;
  int worse = 0;
  for (std::size_t i = 0; i < none.errors.size(); ++i) {
    const double gain = std::abs(none.errors[i]) - std::abs(shifted.errors[i]);
    if (gain > kClearGain) ++better;
    if (gain < -kClearGain) ++worse;
  }
  return better >= kFewestBetter && better >= kBetterThanWorse * worse;
}

}  // namespace

void OdometryLag::add(const Step& step) {
  const bool continues = !steps_.empty() && step.from == steps_.back().to &&
                         (step.to - step.from).seconds() < kGapS && step.to > step.from;
  if (!continues) steps_.clear();
  if (!(step.to > step.from)) return;
  steps_.push_back(step);
  if (steps_.size() > kSteps) steps_.pop_front();
  if (++since_judged_ >= kJudgeEvery && steps_.size() >= kFewestSteps) {
    since_judged_ = 0;
    judge();
  }
}

void OdometryLag::judge() {
  const Unrolled odometry(steps_);
  const double interval_s = odometry.end_s() / static_cast<double>(steps_.size());
  const double unit_s = std::max(interval_s, kFinestS);
  const int shifts = std::clamp(static_cast<int>(kLongestS / unit_s), 1, kMostShifts);
  const double margin_s = shifts * unit_s;
  const Misfit none = misfit(steps_, odometry, 0.0, margin_s);
  if (none.steps < kFewestSteps / 2) return;
  const double noise = kNoise2 * static_cast<double>(none.steps);
  Misfit best = none;
  double best_shift_s = 0.0;
  for (int k = -shifts; k <= shifts; ++k) {
    const double shift_s = k * unit_s;
    Misfit shifted = misfit(steps_, odometry, shift_s, margin_s);
    if (shifted.squared >= best.squared) continue;
    best = std::move(shifted);
    best_shift_s = shift_s;
  }
  // At an end of the range the true shift is unknown, and so is whether there is one.
  const bool inside = std::abs(best_shift_s) < margin_s - 0.5 * unit_s;
  if (none.squared > kConvincing * (best.squared + noise) && inside &&
      many_fit_better(best, none)) {
    lag_s_ = best_shift_s;
  } else if (lag_s_ && none.squared < kAllClear * (best.squared + noise)) {
    // Only a robot that speeds up and turns can show that odometry is in time again.
    const Misfit late = misfit(steps_, odometry, *lag_s_, margin_s);
    if (late.squared > kConvincing * (none.squared + noise) && many_fit_better(none, late))
      lag_s_.reset();
  }
}

}  // namespace loopstone
